// Table of integrator names, including those of other renderers with the same expected image.
#include "scene/dialects/common/integrator_name.h"

#include "scene/dialects/common/known_names.h"
#include "scene/dialects/common/visibility_integrators.h"

#include <algorithm>
#include <iterator>
#include <string>

namespace sheaf {

namespace {

/// Light samples per vertex for the `_ris` integrators.
constexpr int kResampledCandidates = 8;

constexpr auto kPath = IntegratorKind::kPath;
constexpr auto kMaps = IntegratorKind::kPhotonMapper;
constexpr auto kMis = LightStrategy::kMis;
constexpr auto kMats = LightStrategy::kBsdfOnly;
constexpr auto kEms = LightStrategy::kLightOnly;

constexpr NamedIntegrator kIntegrators[] = {
    {"path", kPath, kMis, false},
    {"path_mis", kPath, kMis, false},
    {"path_mats", kPath, kMats, false},
    {"path_ems", kPath, kEms, false},
    {"path_ris", kPath, kMis, false, kResampledCandidates},
    {"direct", kPath, kMis, true},
    {"direct_mis", kPath, kMis, true},
    {"direct_mats", kPath, kMats, true},
    {"direct_ems", kPath, kEms, true},
    {"direct_ris", kPath, kMis, true, kResampledCandidates},
    {"whitted", kPath, kEms, false, 1, false, false, true},
    {"normals", IntegratorKind::kNormals, kMis, false},
    {"depth", IntegratorKind::kDepth, kMis, false},
    {"volpath", kPath, kMis, false, 1, true},
    {"volpathmis", kPath, kMis, false, 1, true},
    {"volpath_simple", kPath, kMis, false, 1, true},
    {"volpath_mis", kPath, kMis, false},
    {"volpath_mats", kPath, kMats, false},
    {"vol_path", kPath, kMis, false},
    {"vol_path_mis", kPath, kMis, false},
    {"vol_path_mats", kPath, kMats, false},
    {"path_vol", kPath, kMis, false},
    {"path_vol_mis", kPath, kMis, false},
    {"path_vol_mats", kPath, kMats, false},
    {"path_mis_vol", kPath, kMis, false},
    {"medium_path", kPath, kMis, false},
    {"medium_path_mis", kPath, kMis, false},
    {"medium_path_mats", kPath, kMats, false},
    {"simplepath", kPath, kMis, false},
    {"simplevolpath", kPath, kMis, false},
    {"ptracer", IntegratorKind::kLightTracer, kMis, false},
    {"lightpath", IntegratorKind::kLightTracer, kMis, false},
    {"photonmapper", kMaps, kMis, false},
    {"photonmap", kMaps, kMis, false},
    {"volumetricphotonmapper", kMaps, kMis, false},
    {"ppm", kMaps, kMis, false, 1, false, true},
    {"sppm", kMaps, kMis, false, 1, false, true},
};

/// Integrators of other renderers whose expected image is that of `path`.
constexpr const char* kLikePath[] = {
    "adaptive",
    "bdpt",
    "erpt",
    "guided_path",
    "irrcache",
    "mlt",
    "path_guiding_integrator",
    "path_tracer_recursive",
    "prb",
    "prb_basic",
    "prb_projective",
    "prb_reparam",
    "pssmlt",
    "randomwalk",
    "singlescatter",
    "vcm",
    "vpl",
    "vrl",
};
/// The same for `direct` and `volpath`.
constexpr const char* kLikeDirect[] = {"direct_projective", "direct_reparam", "emission_reparam"};
constexpr const char* kLikeVolpath[] = {"prbvolpath"};

template <std::size_t n> bool is_one_of(std::string_view name, const char* const (&list)[n]) {
  return std::find(std::begin(list), std::end(list), name) != std::end(list);
}

}  // namespace

const char* same_expectation(std::string_view name) {
  if (is_one_of(name, kLikePath)) return "path";
  if (is_one_of(name, kLikeDirect)) return "direct";
  if (is_one_of(name, kLikeVolpath)) return "volpath";
  return nullptr;
}

const NamedIntegrator* find_integrator(std::string_view name) {
  if (const char* same = same_expectation(name)) name = same;
  for (const NamedIntegrator& named : kIntegrators)
    if (name == named.name) return &named;
  return nullptr;
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const NamedIntegrator& named : kIntegrators) names.emplace_back(named.name);
  for (const char* name : kLikePath) names.emplace_back(name);
  for (const char* name : kLikeDirect) names.emplace_back(name);
  for (const char* name : kLikeVolpath) names.emplace_back(name);
  names.insert(names.end(), {"ambientocclusion", "ao", "av"});
  std::sort(names.begin(), names.end());
  return names;
}

void apply(const NamedIntegrator& named, IntegratorSettings& integrator) {
  PhotonMappingSettings& photons = integrator.photons;
  if (named.progressive && !photons.progressive) {
    photons.gathering = PhotonGathering::kIndirect;
    if (integrator.kind != IntegratorKind::kPhotonMapper) photons.global = {250'000, 0, 0};
  }
  photons.progressive = named.progressive;
  integrator.kind = named.kind;
  integrator.strategy = named.strategy;
  integrator.thin_dielectrics_are_free = named.thin_dielectrics_are_free;
  integrator.ends_at_diffuse = named.ends_at_diffuse;
  if (named.candidates > 1) integrator.candidates = named.candidates;
  if (named.direct) integrator.max_depth = 2;
}

std::string stand_in_note(std::string_view name) {
  const char* same = same_expectation(name);
  if (same == nullptr) return {};
  return "integrator '" + std::string(name) + "' is rendered with '" + same + "', which has the same expectation";
}

void apply_integrator_name(std::string_view name, Description& description) {
  if (is_visibility_integrator(name)) {
    const float length = description.integrator.visibility_length;
    apply_visibility_integrator(name, length, true, description);
    return;
  }
  const NamedIntegrator* named = find_integrator(name);
  if (named == nullptr)
    throw Error(ExitCode::kUsage, "unknown integrator '" + std::string(name) + "'" +
                                      did_you_mean(name, integrator_names()) + known_names(integrator_names()));
  apply(*named, description.integrator);
  if (std::string note = stand_in_note(name); !note.empty()) description.notes.push_back(std::move(note));
}

}  // namespace sheaf

// Table of integrator names, including those of other renderers with the same expected image.
#include "scene/dialects/common/integrator_name.h"

#include "scene/dialects/common/visibility_integrators.h"

#include <algorithm>
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

constexpr NameTable<IntegratorChoice> kIntegrators{{
    {"path", {kPath, kMis}},
    {"path_mis", {kPath, kMis}},
    {"path_mats", {kPath, kMats}},
    {"path_ems", {kPath, kEms}},
    {"path_ris", {kPath, kMis, false, kResampledCandidates}},
    {"direct", {kPath, kMis, true}},
    {"direct_mis", {kPath, kMis, true}},
    {"direct_mats", {kPath, kMats, true}},
    {"direct_ems", {kPath, kEms, true}},
    {"direct_ris", {kPath, kMis, true, kResampledCandidates}},
    {"whitted", {kPath, kEms, false, 1, false, false, true}},
    {"normals", {IntegratorKind::kNormals, kMis}},
    {"depth", {IntegratorKind::kDepth, kMis}},
    {"volpath", {kPath, kMis, false, 1, true}},
    {"volpathmis", {kPath, kMis, false, 1, true}},
    {"volpath_simple", {kPath, kMis, false, 1, true}},
    {"volpath_mis", {kPath, kMis}},
    {"volpath_mats", {kPath, kMats}},
    {"vol_path", {kPath, kMis}},
    {"vol_path_mis", {kPath, kMis}},
    {"vol_path_mats", {kPath, kMats}},
    {"path_vol", {kPath, kMis}},
    {"path_vol_mis", {kPath, kMis}},
    {"path_vol_mats", {kPath, kMats}},
    {"path_mis_vol", {kPath, kMis}},
    {"medium_path", {kPath, kMis}},
    {"medium_path_mis", {kPath, kMis}},
    {"medium_path_mats", {kPath, kMats}},
    {"simplepath", {kPath, kMis}},
    {"simplevolpath", {kPath, kMis}},
    {"ptracer", {IntegratorKind::kLightTracer, kMis}},
    {"lightpath", {IntegratorKind::kLightTracer, kMis}},
    {"photonmapper", {kMaps, kMis}},
    {"photonmap", {kMaps, kMis}},
    {"volumetricphotonmapper", {kMaps, kMis}},
    {"ppm", {kMaps, kMis, false, 1, false, true}},
    {"sppm", {kMaps, kMis, false, 1, false, true}},
}};

}  // namespace

constexpr NameTable<const char*> kStandInIntegrators{{
    {"adaptive", "path"},
    {"bdpt", "path"},
    {"direct_projective", "direct"},
    {"direct_reparam", "direct"},
    {"emission_reparam", "direct"},
    {"erpt", "path"},
    {"guided_path", "path"},
    {"irrcache", "path"},
    {"mlt", "path"},
    {"path_guiding_integrator", "path"},
    {"path_tracer_recursive", "path"},
    {"prb", "path"},
    {"prb_basic", "path"},
    {"prb_projective", "path"},
    {"prb_reparam", "path"},
    {"prbvolpath", "volpath"},
    {"pssmlt", "path"},
    {"randomwalk", "path"},
    {"singlescatter", "path"},
    {"vcm", "path"},
    {"vpl", "path"},
    {"vrl", "path"},
}};

const IntegratorChoice* find_integrator(std::string_view name) {
  const char* const* stand_in = kStandInIntegrators.find(name);
  return kIntegrators.find(stand_in != nullptr ? *stand_in : name);
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names = kIntegrators.names();
  for (const auto& row : kStandInIntegrators.rows) names.emplace_back(row.name);
  for (const auto& row : kVisibilityIntegrators.rows) names.emplace_back(row.name);
  std::sort(names.begin(), names.end());
  return names;
}

void apply(const IntegratorChoice& choice, IntegratorSettings& integrator) {
  PhotonMappingSettings& photons = integrator.photons;
  if (choice.progressive && !photons.progressive) {
    photons.gathering = PhotonGathering::kIndirect;
    if (integrator.kind != IntegratorKind::kPhotonMapper) photons.global = {250'000, 0, 0};
  }
  photons.progressive = choice.progressive;
  integrator.kind = choice.kind;
  integrator.strategy = choice.strategy;
  integrator.thin_dielectrics_are_free = choice.thin_dielectrics_are_free;
  integrator.ends_at_diffuse = choice.ends_at_diffuse;
  if (choice.candidates > 1) {
    integrator.candidates = choice.candidates;
    integrator.sets_candidates = true;
  }
  if (choice.direct) integrator.max_depth = 2;
}

std::string stand_in_note(std::string_view name) {
  const char* const* same = kStandInIntegrators.find(name);
  if (same == nullptr) return {};
  return "integrator '" + std::string(name) + "' is rendered with '" + *same + "', which has the same expectation";
}

void fail_integrator(const Properties& p, const std::vector<std::string>& others) {
  std::vector<std::string> known = integrator_names();
  for (const std::string& other : others)
    if (find_integrator(other) == nullptr) known.push_back(other);
  p.fail_plugin(std::move(known));
}

void apply_integrator_name(std::string_view name, Description& description) {
  if (const Visibility* visibility = kVisibilityIntegrators.find(name)) {
    const float length = description.integrator.visibility_length;
    apply_visibility_integrator(*visibility, length, true, description);
    return;
  }
  const IntegratorChoice* choice = find_integrator(name);
  if (choice == nullptr)
    throw Error(ExitCode::kUsage, "unknown integrator '" + std::string(name) + "'" +
                                      did_you_mean(name, integrator_names()) + known_names(integrator_names()));
  apply(*choice, description.integrator);
  if (std::string note = stand_in_note(name); !note.empty()) description.notes.push_back(std::move(note));
}

}  // namespace sheaf

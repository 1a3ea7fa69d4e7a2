#include "scene/dialects/integrator_name.h"

#include <string>

namespace sheaf {

namespace {

/// Candidates per vertex of the integrators named after resampling.
constexpr int kResampledCandidates = 8;

constexpr NamedIntegrator kIntegrators[] = {
    {"path", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"path_mis", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"path_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, false},
    {"path_ems", IntegratorKind::kPath, LightStrategy::kLightOnly, false},
    {"path_ris", IntegratorKind::kPath, LightStrategy::kMis, false, kResampledCandidates},
    {"direct", IntegratorKind::kPath, LightStrategy::kMis, true},
    {"direct_mis", IntegratorKind::kPath, LightStrategy::kMis, true},
    {"direct_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, true},
    {"direct_ems", IntegratorKind::kPath, LightStrategy::kLightOnly, true},
    {"direct_ris", IntegratorKind::kPath, LightStrategy::kMis, true, kResampledCandidates},
    {"normals", IntegratorKind::kNormals, LightStrategy::kMis, false},
    {"depth", IntegratorKind::kDepth, LightStrategy::kMis, false},
    {"volpath", IntegratorKind::kPath, LightStrategy::kMis, false, 1, true},
    {"volpathmis", IntegratorKind::kPath, LightStrategy::kMis, false, 1, true},
    {"volpath_mis", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"volpath_simple", IntegratorKind::kPath, LightStrategy::kMis, false, 1, true},
    {"vol_path", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"vol_path_mis", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"vol_path_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, false},
    {"path_vol_mis", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"path_mis_vol", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"medium_path", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"medium_path_mis", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"medium_path_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, false},
    {"prb", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"prbvolpath", IntegratorKind::kPath, LightStrategy::kMis, false, 1, true},
    {"ptracer", IntegratorKind::kLightTracer, LightStrategy::kMis, false},
    {"photonmapper", IntegratorKind::kPhotonMapper, LightStrategy::kMis, false},
    {"photonmap", IntegratorKind::kPhotonMapper, LightStrategy::kMis, false},
    {"volumetricphotonmapper", IntegratorKind::kPhotonMapper, LightStrategy::kMis, false},
    {"ppm", IntegratorKind::kPhotonMapper, LightStrategy::kMis, false, 1, false, true},
    {"sppm", IntegratorKind::kPhotonMapper, LightStrategy::kMis, false, 1, false, true},
    {"bdpt", IntegratorKind::kPath, LightStrategy::kMis, false},
};

}  // namespace

const NamedIntegrator* find_integrator(std::string_view name) {
  for (const NamedIntegrator& named : kIntegrators)
    if (name == named.name) return &named;
  return nullptr;
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const NamedIntegrator& named : kIntegrators) names.emplace_back(named.name);
  return names;
}

void apply(const NamedIntegrator& named, IntegratorDescription& integrator) {
  PhotonMappingDescription& photons = integrator.photons;
  if (named.progressive && !photons.progressive) {
    photons.gathering = PhotonGathering::kIndirect;
    if (integrator.kind != IntegratorKind::kPhotonMapper) photons.global = {250'000, 0, 0};
  }
  photons.progressive = named.progressive;
  integrator.kind = named.kind;
  integrator.strategy = named.strategy;
  integrator.free_panes = named.free_panes;
  if (named.candidates > 1) integrator.candidates = named.candidates;
  if (named.direct) integrator.max_depth = 2;
}

IntegratorDescription integrator_from_name(std::string_view name, const IntegratorDescription& base) {
  const NamedIntegrator* named = find_integrator(name);
  if (named == nullptr)
    throw Error(ExitCode::kUsage,
                "unknown integrator '" + std::string(name) + "'" + did_you_mean(name, integrator_names()));
  IntegratorDescription integrator = base;
  apply(*named, integrator);
  return integrator;
}

}  // namespace sheaf

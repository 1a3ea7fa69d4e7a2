#include "scene/integrator_name.h"

#include <string>

namespace sheaf {

namespace {

struct NamedIntegrator {
  const char* name;
  IntegratorKind kind;
  LightStrategy strategy;
  bool direct;  ///< light is scattered once
};

constexpr NamedIntegrator kIntegrators[] = {
    {"path", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"path_mis", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"path_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, false},
    {"path_ems", IntegratorKind::kPath, LightStrategy::kLightOnly, false},
    {"direct", IntegratorKind::kPath, LightStrategy::kMis, true},
    {"direct_mis", IntegratorKind::kPath, LightStrategy::kMis, true},
    {"direct_mats", IntegratorKind::kPath, LightStrategy::kBsdfOnly, true},
    {"direct_ems", IntegratorKind::kPath, LightStrategy::kLightOnly, true},
    {"normals", IntegratorKind::kNormals, LightStrategy::kMis, false},
    {"depth", IntegratorKind::kDepth, LightStrategy::kMis, false},
    {"volpath", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"volpathmis", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"prb", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"prbvolpath", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"ptracer", IntegratorKind::kPath, LightStrategy::kMis, false},
    {"bdpt", IntegratorKind::kPath, LightStrategy::kMis, false},
};

}  // namespace

IntegratorDescription integrator_from_name(std::string_view name, const IntegratorDescription& base) {
  std::vector<std::string> known;
  for (const NamedIntegrator& named : kIntegrators) {
    known.emplace_back(named.name);
    if (name != named.name) continue;
    IntegratorDescription integrator = base;
    integrator.kind = named.kind;
    integrator.strategy = named.strategy;
    if (named.direct) integrator.max_depth = 2;
    return integrator;
  }
  throw Error(ExitCode::kUsage, "unknown integrator '" + std::string(name) + "'" + did_you_mean(name, known));
}

}  // namespace sheaf

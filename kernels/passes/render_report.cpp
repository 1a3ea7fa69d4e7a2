#include "kernels/passes/render_report.h"

#include "scene/scene.h"

namespace sheaf {

namespace {

double ratio(double a, double b) { return b > 0 ? a / b : 0.0; }

}  // namespace

std::string integrator_name(const IntegratorSettings& integrator) {
  if (integrator.kind == IntegratorKind::kNormals) return "normals";
  if (integrator.kind == IntegratorKind::kDepth) return "depth";
  if (integrator.kind == IntegratorKind::kVisibility) return "av";
  if (integrator.kind == IntegratorKind::kLightTracer) return "ptracer";
  if (integrator.kind == IntegratorKind::kPhotonMapper) return integrator.photons.progressive ? "sppm" : "photonmapper";
  if (integrator.ends_at_diffuse) return "whitted";
  if (integrator.strategy == LightStrategy::kBsdfOnly) return "path_mats";
  if (integrator.strategy == LightStrategy::kLightOnly) return "path_ems";
  return integrator.max_depth == 2 ? "direct" : "path";
}

double RenderReport::rays_per_second() const { return ratio(static_cast<double>(stats.rays.total()), render_seconds); }

double RenderReport::trace_share() const {
  return ratio(static_cast<double>(stats.trace_ticks) * seconds_per_tick(), render_seconds * threads);
}

double RenderReport::samples_factor(double target) const { return noise ? (*noise / target) * (*noise / target) : 0.0; }

}  // namespace sheaf

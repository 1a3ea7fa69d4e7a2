// Stage: debug view. Pictures of the first surface instead of its light: shading normals, each component as its
// absolute value, or the distance from the camera.
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "scene/shape.h"

namespace sheaf {

namespace {

template <class L>
SHEAF_INLINE void view_tile(const SceneView& scene, Wave& wave, const Slot* slots, int count) {
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  RadianceState<L> out = wave.radiance.gather<L>(slots);
  if (scene.integrator.kind == IntegratorKind::kDepth) {
    out.radiance = {hit.t, hit.t, hit.t, Float<L>(0.0f)};
  } else {
    const ShapeLanes<L> shape = load_shapes<L>(scene, hit.shape);
    const auto y = surface_point<L>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                  hit.instance);
    const Vec3<L> n = abs(y.ns);
    out.radiance = {n.x, n.y, n.z, Float<L>(0.0f)};
  }
  wave.radiance.scatter<L>(slots, count, out);
}

}  // namespace

template <class L> void debug_view(const SceneView& scene, Wave& wave) noexcept {
  StageTimer timer(wave.stats, Stage::kSurfaceInputs);
  const int hits = wave.surface.size();
  timer.count(hits, L::width);
  wave.surface.pad();
  for_tiles<L>(hits, [&](int i, int count) { view_tile<L>(scene, wave, wave.surface.data() + i, count); });
  for (int i = 0; i < hits; ++i) wave.finished.push(wave.surface[i]);
  for (int i = 0; i < wave.miss.size(); ++i) {
    RadianceState<Scalar> out = wave.radiance.get(wave.miss[i]);
    out.task_sample |= kTransparent;
    wave.radiance.set(wave.miss[i], out);
    wave.finished.push(wave.miss[i]);
  }
  wave.surface.clear();
  wave.miss.clear();
  wave.emitter.clear();
}

SHEAF_INSTANTIATE_STAGE(debug_view);

}  // namespace sheaf

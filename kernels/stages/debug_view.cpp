// Stage: debug view. Renders the first surface without light transport: absolute components of its shading normal, its
// distance from the camera, or its visibility by one shadow ray. Hidden lights do not count as surfaces.
#include "core/math/frame.h"
#include "core/sampling/warp.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/push_shadow_ray.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

namespace {

template <class L> SHEAF_INLINE void view_tile(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  RadianceState<L> out = wave.radiance.gather<L>(slots);
  if (context.integrator.kind == IntegratorKind::kDepth) {
    const Float<L> depth =
        keeps_distance_since_vertex(context) ? hit.t + gather_distance_since_vertex<L>(wave, slots) : hit.t;
    out.radiance = {depth, depth, depth, Float<L>(0.0f)};
  } else {
    const ShapeRecord<L> shape = gather_rows<L>(context.scene.geometry.shapes, hit.shape);
    const auto y =
        surface_point<L>(context.scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                         hit.instance, path_times<L>(context.scene, wave, slots));
    const Vec3<L> n = abs(y.ns);
    out.radiance = {n.x, n.y, n.z, Float<L>(0.0f)};
  }
  wave.radiance.scatter<L>(slots, count, out);
}

/// Pushes a shadow ray in a uniformly sampled direction of the hemisphere around the shading normal.
template <class L>
SHEAF_INLINE void look_around_tile(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const PathState<L> path = wave.paths.gather<L>(slots);
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, hit.shape);
  const auto y = surface_point<L>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                  hit.instance, path_times<L>(scene, wave, slots));
  const auto u = draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kScatter);
  const Vec3<L> direction = Frame<L>::from_normal(y.ns).to_world(square_to_cone<L>(u.y, u.z, F(1.0f)));
  // The length never needs to exceed the diameter of the scene's bounding sphere.
  const F length(min(context.integrator.visibility_length, 2.1f * scene.radius));
  VertexItem<L> item{};
  item.p = y.p, item.ng = y.ng, item.offset = y.offset;
  push_shadow_ray<L>(scene, wave, slots, count, item, {y.p + direction * length, F(0.0f), U(kNone), U(kNone)},
                     {F(1.0f), F(1.0f), F(1.0f), F(0.0f)}, false);
}

template <class L>
SHEAF_INLINE void pass_hidden_tile(const SceneView& scene, Wave& wave, const Slot* slots, int count) {
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, hit.shape);
  const auto y = surface_point<L>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                  hit.instance, path_times<L>(scene, wave, slots));
  continue_rays<L>(scene, wave, slots, count, Mask<L>(true), y, shape.boundary, hit, ray, wave.paths.gather<L>(slots));
}

}  // namespace

template <class L> void debug_view(const StageContext& context, Wave& wave) noexcept {
  const int hits = wave.surface.size();
  if (hits + wave.miss.size() + wave.emitter.size() == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("debug_view"));
  timer.count(hits, L::width);
  wave.surface.pad();
  const bool looks_around = context.integrator.traits().measures_visibility;
  for_tiles<L>(hits, [&](int i, int count) {
    if (looks_around)
      look_around_tile<L>(context, wave, wave.surface.data() + i, count);
    else
      view_tile<L>(context, wave, wave.surface.data() + i, count);
  });
  for (int i = 0; i < hits; ++i) wave.finished.push(wave.surface[i]);
  for (int i = 0; i < wave.miss.size(); ++i) {
    if (looks_around)
      wave.radiance.row(wave.miss[i]).radiance = {1.0f, 1.0f, 1.0f, 0.0f};
    else
      mark_transparent(wave, wave.miss[i]);
    wave.finished.push(wave.miss[i]);
  }
  // All rays come from the camera, so slots in `emitter` are in no other list if lights are hidden.
  if (context.integrator.hide_emitters) {
    wave.emitter.pad();
    for_tiles<L>(wave.emitter.size(),
                 [&](int i, int count) { pass_hidden_tile<L>(context.scene, wave, wave.emitter.data() + i, count); });
  }
  wave.surface.clear();
  wave.miss.clear();
  wave.emitter.clear();
}

SHEAF_INSTANTIATE_STAGE(debug_view);

}  // namespace sheaf

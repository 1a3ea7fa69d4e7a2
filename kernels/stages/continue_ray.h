// Continues rays behind surfaces that do not scatter them: null interfaces, masks and hidden lights. Thin dielectrics
// and shadow rays share parts of this code.
#pragma once

#include "core/soa/lane_array.h"
#include "kernels/stages/medium_boundary.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/wave.h"
#include "scene/surfaces/shape.h"

#include <bit>

namespace sheaf {

/// A ray behind a surface that it has crossed: its origin, and RayState::flags with its new medium.
template <class L> struct RayBehind {
  Vec3<L> origin;
  typename L::Uint flags;
};

/// The ray behind `surface` in an unchanged direction.
template <class L>
SHEAF_INLINE RayBehind<L> ray_behind(const SceneView& scene, const SurfacePoint<L>& surface,
                                     const BoundaryCrossing<L>& at, Vec3<L> direction, Uint<L> flags) {
  return {offset_origin<L>(surface.p, surface.ng, surface.offset, direction),
          medium_behind<L>(scene, at, surface.ng, direction, flags)};
}

/// Whether Wave::distance_since_vertex is maintained.
inline bool keeps_distance_since_vertex(const StageContext& context) {
  return context.scene.needs_transmittance || context.integrator.hide_emitters;
}

/// Gathers words of Wave::distance_since_vertex.
template <class L> SHEAF_INLINE Float<L> gather_distance_since_vertex(const Wave& wave, const Slot* slots) {
  return make_lanes<Float<L>>([&](int lane) SHEAF_LAMBDA_INLINE { return wave.distance_since_vertex[slots[lane]]; });
}

/// Adds `distance`, m, to the distance of the paths of `lanes` since their last vertex.
template <class L>
SHEAF_INLINE void add_distance_since_vertex(Wave& wave, const Slot* slots, std::uint32_t lanes, Float<L> distance) {
  const LaneArray<Float<L>> more(distance);
  for_each_lane(lanes, [&](int lane) SHEAF_LAMBDA_INLINE { wave.distance_since_vertex[slots[lane]] += more[lane]; });
}

/// Continues the paths of `passing` behind the surface that their rays hit. They become active, or finished when their
/// dimension reaches kLongestPath. `boundary`: ShapeRow::boundary of the surface. `hit`, `ray`, `path`: their states.
/// The far end of the ray stays in place, and random numbers behind the surface are new ones.
template <class L>
SHEAF_INLINE void continue_rays(const SceneView& scene, Wave& wave, const Slot* slots, int count, Mask<L> passing,
                                const SurfacePoint<L>& surface, Uint<L> boundary, const HitState<L>& hit,
                                RayState<L> ray, PathState<L> path) {
  using F = Float<L>;
  using U = Uint<L>;
  const std::uint32_t pass = mask_bits(passing & L::first(count));
  if (pass == 0) return;
  const BoundaryCrossing<L> at{boundary, hit.instance, path_times<L>(scene, wave, slots)};
  const RayBehind<L> behind = ray_behind<L>(scene, surface, at, ray.direction, ray.flags);
  ray.origin = select<L>(passing, behind.origin, ray.origin);
  ray.flags = select(passing, behind.flags, ray.flags);
  ray.t_max = select(passing, max(ray.t_max - hit.t, F(0.0f)), ray.t_max);
  wave.rays.scatter<L>(slots, count, ray);
  add_distance_since_vertex<L>(wave, slots, pass, hit.t);
  std::uint32_t crossing = pass;
  // Other scenes draw no random numbers between one surface and the next.
  if (scene.needs_transmittance) {
    crossing &= mask_bits(path.dimension() < U(kLongestPath));
    path.depth_and_dimension = select(passing, path.depth_and_dimension + U(kOneDimension), path.depth_and_dimension);
    wave.paths.scatter<L>(slots, count, path);
  }
  wave.stats.rays.scatter += static_cast<std::uint64_t>(std::popcount(crossing));
  wave.active.push(slots, crossing);
  wave.finished.push(slots, pass & ~crossing);
}

}  // namespace sheaf

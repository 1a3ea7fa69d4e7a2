// Finds the medium in which rays start, where it is not known from a previous vertex.
#pragma once

#include "core/soa/lane_array.h"
#include "kernels/stages/trace_packets.h"
#include "kernels/wave/path_state.h"
#include "scene/surfaces/shape.h"
#include "scene/tables/exterior_medium.h"

namespace sheaf {

/// 1 + row of the medium at the origin of the rays of `lanes`, or 0 for vacuum. `time`: of the rays, in [0, 1]. The
/// first boundary that a ray hits gives the medium on its near side. Rays that hit no boundary start in the outer
/// medium.
template <class L>
Uint<L> start_medium(const SceneView& scene, Wave& wave, Vec3<L> origin, Vec3<L> direction, Float<L> time,
                     Mask<L> lanes) {
  /// Rays that cross more surfaces are assumed to start in the outer medium.
  constexpr int kMaxCrossings = 1000;
  using U = Uint<L>;
  if (scene.media.boundaries == nullptr) return U(scene.media.outer_medium);
  LaneRows<L, Vec3> origins(origin);
  const LaneRows<L, Vec3> directions(direction);
  const LaneArray<Float<L>> times(time);
  LaneArray<U> medium(U(scene.media.outer_medium));
  int lane_of[L::width], active_count = 0;
  for_each_lane(mask_bits(lanes), [&](int lane) { lane_of[active_count++] = lane; });
  // Trace from surface to surface up to a boundary of media
  for (int round = 0; active_count > 0 && round < kMaxCrossings; ++round) {
    int next = 0;
    trace_packets(
        scene, wave, active_count, RayRecorder::Query::kNearest,
        [&](int first, int count, RayPacket& packet) {
          for (int i = 0; i < count; ++i) {
            packet.set_ray(i, origins[lane_of[first + i]], directions[lane_of[first + i]]);
            packet.time[i] = times[lane_of[first + i]];
            packet.shape[i] = kNone;
          }
        },
        [&](int first, int count, const RayPacket& packet) {
          for (int i = 0; i < count; ++i) {
            if (packet.shape[i] == kNone) continue;
            const int lane = lane_of[first + i];
            const Vec3f along = directions[lane], from = origins[lane];
            const ShapeRecord<Scalar> shape = gather_rows<Scalar>(scene.geometry.shapes, packet.shape[i]);
            const auto y =
                surface_point<Scalar, false>(scene, shape, packet.primitive[i], packet.u[i], packet.v[i],
                                             from + along * packet.t_far[i], packet.instance[i], times[lane]);
            // Find the medium on the near side of the boundary
            if (shape.boundary != kNone) {
              medium[lane] = dot(y.ng, along) < 0.0f
                                 ? exterior_medium(scene.media, shape.boundary, packet.instance[i], times[lane])
                                 : scene.media.boundaries[shape.boundary].interior;
              continue;
            }
            // Continue behind other surfaces
            origins.set(lane, offset_origin<Scalar>(y.p, y.ng, y.offset, along));
            lane_of[next++] = lane;
          }
        });
    active_count = next;
  }
  return medium.load();
}

}  // namespace sheaf

// Finds the medium in which rays start, where it is not known from a previous vertex.
#pragma once

#include "kernels/stages/trace_packets.h"
#include "kernels/wave/path_state.h"
#include "scene/tables/shape.h"

#include <bit>

namespace sheaf {

/// 1 + row of the medium at the origin of the rays of `lanes`, or 0 for vacuum. The first boundary that a ray hits
/// gives the medium on its near side. Rays that hit no boundary start in the outer medium.
template <class L>
Uint<L> start_medium(const SceneView& scene, Wave& wave, Vec3<L> origin, Vec3<L> direction, Mask<L> lanes) {
  /// Rays that cross more surfaces are assumed to start in the outer medium.
  constexpr int kMaxCrossings = 1000;
  using U = Uint<L>;
  if (scene.media.boundaries == nullptr) return U(scene.media.outer_medium);
  alignas(kSimdAlignment) float o[3][L::width], d[3][L::width];
  alignas(kSimdAlignment) std::uint32_t medium[L::width];
  store(o[0], origin.x), store(o[1], origin.y), store(o[2], origin.z);
  store(d[0], direction.x), store(d[1], direction.y), store(d[2], direction.z);
  store(medium, U(scene.media.outer_medium));
  int lane_of[L::width], going = 0;
  for (std::uint32_t left = mask_bits(lanes); left != 0; left &= left - 1) lane_of[going++] = std::countr_zero(left);
  for (int round = 0; going > 0 && round < kMaxCrossings; ++round) {
    int next = 0;
    trace_packets(
        scene, wave, going, RayRecorder::Query::kNearest,
        [&](int first, int count, RayPacket& packet) {
          for (int i = 0; i < count; ++i) {
            const int lane = lane_of[first + i];
            packet.origin_x[i] = o[0][lane], packet.origin_y[i] = o[1][lane], packet.origin_z[i] = o[2][lane];
            packet.direction_x[i] = d[0][lane], packet.direction_y[i] = d[1][lane], packet.direction_z[i] = d[2][lane];
            packet.t_far[i] = kInfinity;
            packet.shape[i] = kNone;
          }
        },
        [&](int first, int count, const RayPacket& packet) {
          for (int i = 0; i < count; ++i) {
            if (packet.shape[i] == kNone) continue;
            const int lane = lane_of[first + i];
            const Vec3f along{d[0][lane], d[1][lane], d[2][lane]};
            const Vec3f from{o[0][lane], o[1][lane], o[2][lane]};
            const ShapeRecord<Scalar> shape = gather_rows<Scalar>(scene.geometry.shapes, packet.shape[i]);
            const auto y = surface_point<Scalar, false>(scene, shape, packet.primitive[i], packet.u[i], packet.v[i],
                                                        from + along * packet.t_far[i], packet.instance[i]);
            if (shape.boundary != kNone) {
              const BoundaryRow& sides = scene.media.boundaries[shape.boundary];
              medium[lane] = dot(y.ng, along) < 0.0f ? sides.exterior : sides.interior;
              continue;
            }
            const Vec3f on = offset_origin<Scalar>(y.p, y.ng, y.offset, along);
            o[0][lane] = on.x, o[1][lane] = on.y, o[2][lane] = on.z;
            lane_of[next++] = lane;
          }
        });
    going = next;
  }
  U out;
  load(medium, out);
  return out;
}

}  // namespace sheaf

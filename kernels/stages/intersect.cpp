// Stage: intersect. Traces active rays with Embree, sixteen at a time, and pushes the paths to queues by what they hit.
#include "kernels/stages/route_hits.h"
#include "kernels/stages/stage_list.h"
#include "kernels/stages/trace_packets.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

namespace {

/// Embree asserts that coordinates stay below about 1.8e18.
constexpr float kLargestCoordinate = 1e18f;

template <class L> SHEAF_INLINE Mask<L> is_traceable(const RayState<L>& ray) {
  const Float<L> origin = max_component(abs(ray.origin)), squared = dot(ray.direction, ray.direction);
  // NaN fails every comparison, but max() may discard a NaN; the sum keeps it.
  const Float<L> sum = ray.origin.x + ray.origin.y + ray.origin.z;
  return (origin <= Float<L>(kLargestCoordinate)) & is_finite(sum) & (squared > Float<L>(0.5f)) &
         (squared < Float<L>(2.0f));
}

/// Copies the rays of slots[0 .. L::width) to lanes [at, at + L::width) of the packet. Returns the lanes that are
/// traceable; the others become rays of length 0.
template <class L>
SHEAF_INLINE std::uint32_t pack(const SceneView& scene, const Wave& wave, const Slot* slots, int count,
                                RayPacket& packet, int at) {
  using F = typename L::Float;
  RayState<L> ray = wave.rays.gather<L>(slots);
  const auto good = is_traceable(ray);
  if (!all(good)) {
    ray.origin = select<L>(good, ray.origin, Vec3<L>{});
    ray.direction = select<L>(good, ray.direction, Vec3<L>{F(0.0f), F(0.0f), F(1.0f)});
    ray.t_max = select(good, ray.t_max, F(0.0f));
  }
  store(packet.origin_x + at, ray.origin.x);
  store(packet.origin_y + at, ray.origin.y);
  store(packet.origin_z + at, ray.origin.z);
  store(packet.direction_x + at, ray.direction.x);
  store(packet.direction_y + at, ray.direction.y);
  store(packet.direction_z + at, ray.direction.z);
  store(packet.t_far + at, ray.t_max);
  pack_times<L>(scene, wave, slots, packet.time + at);
  store(packet.shape + at, typename L::Uint(kNone));
  store(packet.id + at, ray.flags);
  return mask_bits(good & L::first(count));
}

/// Stores the hits of lanes [at, at + L::width) and pushes their slots to queues.
template <class L>
SHEAF_INLINE void unpack(const StageContext& context, Wave& wave, const Slot* slots, int count, const RayPacket& packet,
                         int at, std::uint32_t good) {
  using F = typename L::Float;
  using U = typename L::Uint;
  HitState<L> hit;
  load(packet.t_far + at, hit.t);
  load(packet.u + at, hit.u);
  load(packet.v + at, hit.v);
  load(packet.primitive + at, hit.primitive);
  load(packet.shape + at, hit.shape);
  load(packet.instance + at, hit.instance);
  // Look up the material of the side that was hit, and the light
  const auto found = hit.shape != U(kNone);
  const ShapeRecord<L> shape = gather_rows<L>(context.scene.geometry.shapes, select(found, hit.shape, U(0u)));

  Vec3<L> normal, direction;
  load(packet.normal_x + at, normal.x);
  load(packet.normal_y + at, normal.y);
  load(packet.normal_z + at, normal.z);
  load(packet.direction_x + at, direction.x);
  load(packet.direction_y + at, direction.y);
  load(packet.direction_z + at, direction.z);
  const U back = gather_member<L>(context.scene.materials.rows, &MaterialRow::back, shape.material);
  hit.material = select(dot(normal, direction) > F(0.0f), back, shape.material);
  hit.light = select(found, shape.light, U(kNone));
  const auto instanced = found & (hit.instance != U(kNone)) & (hit.light != U(kNone));
  if (any(instanced)) {
    const U first = gather_member<L>(context.scene.geometry.instances, &InstanceRow::first_light,
                                     select(instanced, hit.instance, U(0u)));
    hit.light = hit.light + select(instanced, first, U(0u));
  }
  wave.hits.scatter<L>(slots, count, hit);

  // Push the slots to queues
  U flags;
  load(packet.id + at, flags);
  wave.finished.push(slots, ((1u << count) - 1u) & ~good);
  std::uint32_t in_vacuum = good;
  if (context.scene.needs_transmittance && context.transports_light()) {
    in_vacuum = good & mask_bits((flags >> kRayMediumShift) == U(0u));
    wave.medium.push(slots, good & ~in_vacuum);
  }
  route_hits<L>(context, wave, slots, in_vacuum, {found, hit.light, hit.material, flags});
}

void report_dropped(Wave& wave, const Slot* slots, int count, std::uint32_t good) noexcept {
  for (int lane = 0; lane < count; ++lane) {
    if (good >> lane & 1u) continue;
    ++wave.stats.dropped.rays;
    if (wave.first_dropped.any) continue;
    const PathState<Scalar> state = wave.paths.get(slots[lane]);
    wave.first_dropped = {true, state.pixel, state.sample};
  }
}

}  // namespace

template <class L> void intersect(const StageContext& context, Wave& wave) noexcept {
  const int rays = wave.active.size();
  if (rays == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("intersect"));
  timer.count(rays, kPacketWidth);
  wave.active.pad();
  std::uint32_t good[kPacketWidth] = {};
  trace_packets(
      context.scene, wave, rays, RayRecorder::Query::kNearest,
      [&](int first, int in_packet, RayPacket& packet) {
        const Slot* slots = wave.active.data() + first;
        for_tiles<L>(in_packet, [&](int at, int count) {
          good[at] = pack<L>(context.scene, wave, slots + at, count, packet, at);
        });
      },
      [&](int first, int in_packet, const RayPacket& packet) {
        const Slot* slots = wave.active.data() + first;
        for_tiles<L>(in_packet, [&](int at, int count) {
          if (std::popcount(good[at]) != count) report_dropped(wave, slots + at, count, good[at]);
          unpack<L>(context, wave, slots + at, count, packet, at, good[at]);
        });
      });
  wave.active.clear();
}

SHEAF_INSTANTIATE_STAGE(intersect);

}  // namespace sheaf

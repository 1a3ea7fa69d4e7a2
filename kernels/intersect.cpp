// Stage: intersect. Packs active rays sixteen at a time, asks Embree for the nearest hits, and splits the paths by what
// they met.
#include "kernels/route_hits.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "scene/shape.h"

namespace sheaf {

namespace {

/// Embree asserts that coordinates stay below about 1.8e18.
constexpr float kLargestCoordinate = 1e18f;

template <class L> SHEAF_INLINE Mask<L> is_traceable(const RayState<L>& ray) {
  const Float<L> origin = max_component(abs(ray.origin)), squared = dot(ray.direction, ray.direction);
  // NaN fails every comparison, but max() may lose it: the sum keeps it.
  const Float<L> sum = ray.origin.x + ray.origin.y + ray.origin.z;
  return (origin <= Float<L>(kLargestCoordinate)) & is_finite(sum) & (squared > Float<L>(0.5f)) &
         (squared < Float<L>(2.0f));
}

/// Rays of slots[0 .. L::width) to lanes [at, at + L::width) of the packet; returns which are good. Others become a
/// ray of no length.
template <class L>
SHEAF_INLINE std::uint32_t pack(const Wave& wave, const Slot* slots, int count, RayPacket& packet, int at) {
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
  store(packet.shape + at, typename L::Uint(kNone));
  store(packet.id + at, ray.flags);
  return mask_bits(good & L::first(count));
}

/// Hits of lanes [at, at + L::width): state, and which lists the paths go to.
template <class L>
SHEAF_INLINE void unpack(const SceneView& scene, Wave& wave, const Slot* slots, int count, const RayPacket& packet,
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
  const auto found = hit.shape != U(kNone);
  const ShapeLanes<L> shape = load_shapes<L>(scene, select(found, hit.shape, U(0u)));

  Vec3<L> normal, direction;
  load(packet.normal_x + at, normal.x);
  load(packet.normal_y + at, normal.y);
  load(packet.normal_z + at, normal.z);
  load(packet.direction_x + at, direction.x);
  load(packet.direction_y + at, direction.y);
  load(packet.direction_z + at, direction.z);
  constexpr auto kRowWords = static_cast<std::uint32_t>(sizeof(MaterialRow) / sizeof(std::uint32_t));
  const auto* materials = reinterpret_cast<const std::uint32_t*>(scene.materials);
  const U back = gather(materials + offsetof(MaterialRow, back) / sizeof(std::uint32_t), shape.material * U(kRowWords));
  hit.material = select(dot(normal, direction) > F(0.0f), back, shape.material);
  hit.light = select(found, shape.light, U(kNone));
  const auto instanced = found & (hit.instance != U(kNone)) & (hit.light != U(kNone));
  if (any(instanced)) {
    constexpr auto kWords = static_cast<std::uint32_t>(sizeof(InstanceRow) / sizeof(std::uint32_t));
    const auto* first = &scene.instances->first_light;
    hit.light = hit.light + select(instanced, gather(first, select(instanced, hit.instance, U(0u)) * U(kWords)), U(0u));
  }
  wave.hits.scatter<L>(slots, count, hit);

  U flags;
  load(packet.id + at, flags);
  wave.finished.push(slots, ((1u << count) - 1u) & ~good);
  std::uint32_t in_vacuum = good;
  if (scene.has_transparency && scene.integrator.kind == IntegratorKind::kPath) {
    in_vacuum = good & mask_bits((flags >> kRayMediumShift) == U(0u));
    wave.medium.push(slots, good & ~in_vacuum);
  }
  route_hits<L>(scene, wave, slots, in_vacuum, {found, hit.light, hit.material, flags});
}

void report_dropped(Wave& wave, const Slot* slots, int count, std::uint32_t good) noexcept {
  for (int lane = 0; lane < count; ++lane) {
    if (good >> lane & 1u) continue;
    ++wave.stats.dropped.rays;
    if (wave.first_dropped.any) continue;
    const ThroughputState<Scalar> state = wave.throughput.get(slots[lane]);
    wave.first_dropped = {true, state.pixel, state.sample};
  }
}

}  // namespace

template <class L> void intersect(const SceneView& scene, Wave& wave) noexcept {
  const int rays = wave.active.size();
  if (rays == 0) return;
  StageTimer timer(wave.stats, Stage::kIntersect);
  timer.count(rays, kPacketWidth);
  wave.active.pad();
  RayPacket packet;
  for (int first = 0; first < rays; first += kPacketWidth) {
    const int in_packet = std::min(kPacketWidth, rays - first);
    const Slot* slots = wave.active.data() + first;
    std::uint32_t good[kPacketWidth] = {};
    for_tiles<L>(in_packet, [&](int at, int count) { good[at] = pack<L>(wave, slots + at, count, packet, at); });
    if (wave.recorder) wave.recorder->record(packet, in_packet, RayRecorder::Query::kNearest);
    const std::uint64_t start = timestamp();
    scene.accel->intersect(packet, in_packet);
    wave.stats.trace_ticks += timestamp() - start;
    for_tiles<L>(in_packet, [&](int at, int count) {
      if (std::popcount(good[at]) != count) report_dropped(wave, slots + at, count, good[at]);
      unpack<L>(scene, wave, slots + at, count, packet, at, good[at]);
    });
  }
  wave.active.clear();
}

SHEAF_INSTANTIATE_STAGE(intersect);

}  // namespace sheaf

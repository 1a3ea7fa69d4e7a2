// Stage: transmittance. Shadow rays in scenes where surfaces let light pass and media attenuate it (PBR 14.2.3). Traces
// the nearest hits of all rays, sixteen rays at a time, and repeats this for rays that continue behind a surface.
// Unoccluded contributions get the MIS weight against BSDF sampling, which depends on the media and surfaces along the
// ray (see kernels/stages/resample.cpp and RescaledPdfs):
//     w_l = P_l^2 / (P_l^2 + P_b^2)
// P_l is the mean over the lanes of r_l, and P_b that of r_u times `pdf_ratio`.
#include "kernels/bsdf/thin_dielectric_passage.h"
#include "kernels/lights/light_weight.h"
#include "kernels/media/density_weights.h"
#include "kernels/media/medium_marching.h"
#include "kernels/media/pass_through_probability.h"
#include "kernels/stages/candidate_moments.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/medium_ray.h"
#include "kernels/stages/push_shadow_ray.h"
#include "kernels/stages/shadow_packet.h"
#include "kernels/stages/stage_list.h"
#include "kernels/stages/trace_packets.h"
#include "kernels/stages/uniform_shadows.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Rays that cross more surfaces count as blocked.
constexpr int kMaxCrossings = 4096;

/// A shadow ray between two surfaces.
struct ShadowRay {
  ShadowItem<Scalar> item;
  TransmittanceItem<Scalar> state;
};

ShadowRay load_ray(const Wave& wave, int i) {
  return {wave.shadows.load<Scalar>(i), wave.transmittances.load<Scalar>(i)};
}

void store_ray(Wave& wave, int i, const ShadowRay& ray) {
  wave.shadows.store<Scalar>(i, ray.item);
  wave.transmittances.store<Scalar>(i, ray.state);
}

/// The random-number dimension of a ray in a round. Each segment between surfaces has its own.
std::uint32_t dimension_of(const PathState<Scalar>& path, const ShadowRay& ray, int round) {
  const std::uint32_t from_segment = (ray.state.flags & kShadowFromSegment) != 0 ? kSegmentDimension : 0;
  return path.dimension() | from_segment | static_cast<std::uint32_t>(round) << 16;
}

/// The segment of the ray up to `t` in its medium; empty in vacuum. `to_end`: it is the last segment.
std::optional<MediumRay> segment_of(const StageContext& context, const Wave& wave, const ShadowRay& ray, float t,
                                    bool to_end) {
  if (ray.state.flags >> kRayMediumShift == 0) return std::nullopt;
  const Vec3f d = ray.item.direction;
  const float distance = length(d);
  if (!(distance > 0.0f)) return std::nullopt;
  const auto slot = static_cast<Slot>(ray.item.slot);
  const Spectrum4 lambda = lane_wavelengths(context.scene, wave, slot);
  const Vec3f direction = d * (1.0f / distance);
  const float end = to_end ? medium_end<Scalar>(context.scene, ray.item.origin, direction) : kInfinity;
  return make_medium_ray(context, ray.state.flags, lambda, ray.item.origin, direction, min(distance * t, end),
                         path_time(context.scene, wave, slot));
}

void apply(PathWeights& weights, ShadowRay& ray) {
  weights.beta = weights.beta * Float4(ray.item.contribution);
  weights.r_u = weights.r_u * Float4(ray.state.r_u);
  weights.r_l = weights.r_l * Float4(ray.state.r_l);
  weights.rescale();
  ray.item.contribution = to_spectrum(weights.beta);
  ray.state.r_u = to_spectrum(weights.r_u);
  ray.state.r_l = to_spectrum(weights.r_l);
}

/// Attenuates the light by one segment of a medium. Returns false if nothing is left.
bool pass_medium(const StageContext& context, Wave& wave, const MediumRay& segment, bool to_end, int round,
                 ShadowRay& ray) {
  PathWeights weights{Float4(1.0f), Float4(1.0f), Float4(1.0f)};
  const MediumEstimator estimator = context.integrator.medium_estimator;
  const auto path = wave.paths.get(static_cast<Slot>(ray.item.slot));
  MediumRandom random(context.sampler.seed, path.pixel, path.sample, dimension_of(path, ray, round),
                      MediumStream::kShadow);
  bool open = true;
  if (segment.has(kMediumHomogeneous)) {
    pass_homogeneous(segment, to_end && ray.state.target_medium != kNone, weights);
  } else if (estimator == MediumEstimator::kMarching) {
    pass_by_marching(segment, random, wave.stats.collisions, weights);
  } else {
    open = pass_null_collisions(segment, random, estimator == MediumEstimator::kDelta, wave.stats.collisions, weights);
  }
  apply(weights, ray);
  return open;
}

/// Attenuates the light by the surface that lane `at` of the packet has hit, and moves the origin of the ray behind it.
/// Returns false if the surface blocks the light.
bool pass_surface(const StageContext& context, const Wave& wave, const RayPacket& packet, int at, ShadowRay& ray) {
  const SceneView& scene = context.scene;
  const Vec3f d = ray.item.direction;
  const Vec3f normal{packet.normal_x[at], packet.normal_y[at], packet.normal_z[at]};
  const bool behind = dot(normal, d) > 0.0f;
  const ShapeRecord<Scalar> shape = gather_rows<Scalar>(scene.geometry.shapes, packet.shape[at]);
  // Shadow rays of photons end at the camera, which does not see hidden lights.
  const bool hidden = context.starts_at_lights() && context.integrator.hide_emitters && shape.light != kNone;
  if (hidden && (ray.state.flags & kShadowFromHiddenLight) != 0) return false;
  if (!hidden && !may_pass(scene, shape.material, behind)) return false;
  const Vec3f target = ray.item.origin + d;
  const float u = packet.u[at], v = packet.v[at];
  const auto y =
      surface_point<Scalar, true>(scene, shape, packet.primitive[at], u, v, ray.item.origin + d * packet.t_far[at],
                                  packet.instance[at], packet.time[at]);
  // Find the pass-through probability
  StraightTransmission<Scalar> passage;
  if (hidden) {
    passage = {Spectrum4(1.0f), 1.0f};
    ray.state.flags |= kShadowPassedHiddenLight;
  } else if ((scene.materials.rows[shape.material].flags & kComposite) == 0) {
    const Spectrum4 lambda = lane_wavelengths(scene, wave, static_cast<Slot>(ray.item.slot));
    passage = thin_dielectric_passage(scene, shape.material, dot(y.ns, d) / length(d), lambda);
    // Behind a thin dielectric the camera sees lights, so a light that the ray has passed before blocks it.
    if ((ray.state.flags & kShadowPassedHiddenLight) != 0) return false;
    ray.state.flags &= ~kShadowFromHiddenLight;
  } else {
    passage.probability = pass_through_probability(scene, shape.material, behind,
                                                   {y.uv, packet.shape[at], packet.primitive[at], u, v, y.p});
    passage.attenuation = Spectrum4(passage.probability);
  }
  if (!(passage.probability > 0.0f)) return false;
  ray.item.contribution = ray.item.contribution * passage.attenuation;
  // BSDF sampling passes the surface with this probability, light sampling with certainty.
  ray.state.r_u = ray.state.r_u * passage.probability;
  // Move the origin behind the surface
  const RayBehind<Scalar> behind_it =
      ray_behind<Scalar>(scene, y, {shape.boundary, packet.instance[at], packet.time[at]}, d, ray.state.flags);
  ray.state.flags = behind_it.flags;
  ray.item.origin = behind_it.origin;
  ray.item.direction = target - ray.item.origin;
  return true;
}

/// Adds `found`, the weighted contribution of a ray that has reached its end, to the path in `slot`.
SHEAF_INLINE void add_found(const StageContext& context, Wave& wave, Slot slot, std::uint32_t light,
                            std::uint32_t flags, Float4 found, LightCounter& tally) {
  tally.arrive(light, to_spectrum(found));
  if (context.compares_candidates()) [[unlikely]] {
    const bool is_common = (flags & kShadowFromSegment) != 0;
    (is_common ? add_common_moments : add_unoccluded_moments)(wave, slot, total(found));
  }
  add_radiance(wave, slot, found, light, 1);
}

/// Contributions of rays that have reached their ends, times w_l / P_l. `r_u`: with the pdf of a collision at the end,
/// if the target is a point in a medium.
template <class L>
SHEAF_INLINE Spectrum<L> weigh_found(const SceneView& scene, const Spectrum<L>& contribution, const Spectrum<L>& r_u,
                                     const Spectrum<L>& r_l, Float<L> pdf_ratio) {
  const Float<L> by_light = lane_mean<L>(scene.color, r_l), by_path = lane_mean<L>(scene.color, r_u) * pdf_ratio;
  return contribution * (power_heuristic(by_light, by_path) / by_light);
}

/// Adds the contribution of a ray that has reached its end to its path.
void add_unoccluded(const StageContext& context, Wave& wave, const ShadowRay& ray, LightCounter& tally) {
  if ((ray.state.flags & kShadowFromHiddenLight) != 0) return;
  const auto slot = static_cast<Slot>(ray.item.slot);
  Float4 r_u(ray.state.r_u);
  const std::uint32_t end = ray.state.target_medium;
  if (end != kNone) {
    // For a point in a medium, BSDF sampling must produce a collision there.
    if (ray.state.flags >> kRayMediumShift != end) return;
    const Vec3f p = ray.item.origin + ray.item.direction;
    const MediumRay at = make_medium_ray(context, ray.state.flags, lane_wavelengths(context.scene, wave, slot), p,
                                         {0, 0, 1}, 0.0f, path_time(context.scene, wave, slot));
    r_u = r_u * collision_density(at, at.origin);
  }
  const Spectrum4 found =
      weigh_found<Scalar>(context.scene, ray.item.contribution, to_spectrum(r_u), ray.state.r_l, ray.state.pdf_ratio);
  add_found(context, wave, slot, ray.item.light, ray.state.flags, Float4(found), tally);
}

/// Moves each ray to the next surface, or to its end. Rays that continue are compacted to the front of the columns.
/// Segments for SIMD tracking are queued.
template <class L> class SurfaceCrossing {
 public:
  SurfaceCrossing(const StageContext& context, Wave& wave, int round)
      : context_(context),
        wave_(wave),
        round_(round),
        queue_(context.sampler, MediumStream::kShadow),
        tally_(wave.stats) {}

  /// Moves the first `count` rays of the tile that begins with ray `i` and was traced in lanes `at` and following of
  /// the packet. Rays that end in vacuum or in homogeneous media, or at opaque surfaces, end together.
  void follow_tile(const RayPacket& packet, int at, int i, int count) {
    ShadowTile<L> tile = load_shadow_tile<L>(context_, wave_, packet, at, i);
    const ShadowEvents events = move_uniform<L>(context_, wave_, packet, at, count, tile);
    const LaneRows<L, Spectrum> found(
        weigh_found<L>(context_.scene, tile.item.contribution, tile.state.r_u, tile.state.r_l, tile.state.pdf_ratio));
    // Move rays that cross interfaces to the front, unless others come first
    const bool at_once = events.others == 0 && segment_count_ == 0;
    if (!at_once && events.crossing != 0) {
      wave_.shadows.store<L>(i, tile.item);
      wave_.transmittances.store<L>(i, tile.state);
    }
    // Radiance is added in the order of the rays, so that it does not depend on their positions in tiles.
    for_each_lane(events.all() & ~(at_once ? events.crossing : 0u), [&](int lane) {
      const std::uint32_t bit = 1u << lane;
      if ((events.ended & bit) != 0) return end(i + lane, Float4(found[lane]));
      if ((events.crossing & bit) != 0) return queue({i + lane, kNotQueued, false});
      follow(packet, at + lane, i + lane);
    });
    if (!at_once) return;
    const auto crossing = tile.interface & is_finite(tile.item.direction);
    wave_.transmittances.compress<L>(active_count_, tile.state, crossing);
    active_count_ += wave_.shadows.compress<L>(active_count_, tile.item, crossing);
  }

  /// Tracks the queued segments and continues their rays in order, so that no ray is stored over one that is still
  /// needed.
  void finish() {
    const bool delta = context_.integrator.medium_estimator == MediumEstimator::kDelta;
    queue_.track_shadows<L>(delta);
    for (int i = 0; i < segment_count_; ++i) {
      const QueuedSegment& segment = segments_[static_cast<std::size_t>(i)];
      ShadowRay ray = load_ray(wave_, segment.ray);
      if (segment.queue_index != kNotQueued && !pass_densities(segment.queue_index, delta, ray)) continue;
      if (segment.to_end)
        add_unoccluded(context_, wave_, ray, tally_);
      else if (is_finite(ray.item.direction))
        store_ray(wave_, active_count_++, ray);
    }
    segment_count_ = 0;
    queue_.clear();
  }

  /// Number of rays that continue.
  int active_count() const { return active_count_; }

 private:
  static constexpr int kNotQueued = -1;

  struct QueuedSegment {
    int ray;          ///< row of its ShadowItem
    int queue_index;  ///< kNotQueued: the light is already attenuated
    bool to_end;      ///< the last segment of its ray
  };

  /// Adds the weighted contribution of ray `i`, which has reached its end.
  void end(int i, Float4 found) {
    const ShadowItem<Columns>& item = wave_.shadows.columns();
    add_found(context_, wave_, static_cast<Slot>(item.slot[i]), item.light[i], wave_.transmittances.columns().flags[i],
              found, tally_);
  }

  /// Queues a ray, which continues or ends when its segment is tracked.
  void queue(const QueuedSegment& segment) {
    segments_[static_cast<std::size_t>(segment_count_++)] = segment;
    if (segment_count_ == DensityQueue::kCapacity) finish();
  }

  /// Moves ray `i`, which was traced in lane `at` of the packet.
  void follow(const RayPacket& packet, int at, int i) {
    ShadowRay ray = load_ray(wave_, i);
    const bool to_end = packet.shape[at] == kNone;
    ShadowRay behind = ray;
    // The surface is cheaper to evaluate than the medium, so it comes first.
    if (!to_end && !pass_surface(context_, wave_, packet, at, behind)) return;
    // Queue the segment for SIMD tracking, or attenuate the light by it now
    const auto segment = segment_of(context_, wave_, ray, to_end ? 1.0f : packet.t_far[at], to_end);
    int queue_index = kNotQueued;
    if (segment && is_tracked_by_density(*segment, context_.integrator.medium_estimator)) {
      queue_index = queue_.size();
      const auto path = wave_.paths.get(static_cast<Slot>(ray.item.slot));
      queue_.add(*segment, path.pixel, path.sample, dimension_of(path, ray, round_));
    } else {
      if (segment && !pass_medium(context_, wave_, *segment, to_end, round_, behind)) return;
      if (to_end) return add_unoccluded(context_, wave_, behind, tally_);
    }
    store_ray(wave_, i, behind);
    queue({i, queue_index, to_end});
  }

  /// Attenuates the light by a segment of the queue. Returns false if nothing is left.
  bool pass_densities(int queue_index, bool delta, ShadowRay& ray) {
    std::optional<PathWeights> weights = queue_.passed(queue_index, delta, wave_.stats.collisions);
    if (!weights) return false;
    apply(*weights, ray);
    return max_component(Float4(ray.item.contribution)) > 0.0f;
  }

  const StageContext& context_;
  Wave& wave_;
  int round_, active_count_ = 0, segment_count_ = 0;
  DensityQueue queue_;
  LightCounter tally_;
  std::array<QueuedSegment, DensityQueue::kCapacity> segments_;
};

/// Moves all rays to the next surface, or to their ends. Returns the number of rays that continue.
template <class L> int follow(const StageContext& context, Wave& wave, int rays, int round) {
  SurfaceCrossing<L> all(context, wave, round);
  trace_packets(
      context.scene, wave, rays, RayRecorder::Query::kNearest,
      [&](int first, int count, RayPacket& packet) {
        for_tiles<L>(count, [&](int at, int) {
          pack_shadow_rays<L>(context.scene, wave, first + at, packet, at);
          store(packet.shape + at, Uint<L>(kNone));
        });
      },
      [&](int first, int count, const RayPacket& packet) {
        for_tiles<L>(count, [&](int at, int lanes) { all.follow_tile(packet, at, first + at, lanes); });
      });
  all.finish();
  return all.active_count();
}

}  // namespace

template <class L> void transmittance(const StageContext& context, Wave& wave) noexcept {
  if (wave.shadow_count == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("transmittance"));
  timer.count(wave.shadow_count, kPacketWidth);
  count_shadow_rays(wave);
  int rays = wave.shadow_count;
  for (int round = 0; rays > 0 && round < kMaxCrossings; ++round) rays = follow<L>(context, wave, rays, round);
  wave.shadow_count = 0;
}

SHEAF_INSTANTIATE_STAGE(transmittance);

}  // namespace sheaf

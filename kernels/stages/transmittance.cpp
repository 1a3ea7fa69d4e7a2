// Stage: transmittance. Shadow rays where surfaces may let light pass and media weaken it: nearest hits instead of any,
// sixteen rays at a time, again and again for those that go on. What is unblocked is paid with its weight against BSDF
// sampling, which depends on what the ray met (see kernels/stages/resample.cpp and ProbabilityState):
//     w_l = P_l^2 / (P_l^2 + P_b^2),  P_l, P_b = means over the lanes of r_l, r_u times `pdf_ratio`.
#include "kernels/bsdf/pane.h"
#include "kernels/lights/light_weight.h"
#include "kernels/media/medium_marching.h"
#include "kernels/media/medium_ray.h"
#include "kernels/media/passing_share.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/shadow_packet.h"
#include "kernels/stages/stages.h"
#include "kernels/stages/trace_packets.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Rays that cross more surfaces than this are taken to be blocked.
constexpr int kMostCrossings = 4096;

/// One shadow ray on its way.
struct ShadowRay {
  ShadowItem<Scalar> item;
  TransmittanceItem<Scalar> state;
  MediumRandom random;
};

ShadowRay load_ray(const StageContext& context, const Wave& wave, int i, int round) {
  const auto item = wave.shadows.load<Scalar>(i);
  const auto path = wave.throughput.get(static_cast<Slot>(item.slot));
  // One stream for each stretch between surfaces.
  const std::uint32_t event = path.event() | static_cast<std::uint32_t>(round) << 16;
  return {item, wave.transmittances.load<Scalar>(i),
          MediumRandom(context.sampler.seed, path.pixel, path.sample, event, MediumStream::kShadow)};
}

/// Lets the light pass the ray's medium over the part `t` of the ray; `to_end`: it is the last one. Returns false where
/// nothing is left.
bool pass_medium(const StageContext& context, Wave& wave, ShadowRay& ray, float t, bool to_end) {
  if (ray.state.flags >> kRayMediumShift == 0) return true;
  const Vec3f d = ray.item.direction;
  const float whole = length(d);
  if (!(whole > 0.0f)) return true;
  const Spectrum4 lambda = lane_wavelengths(context.scene, wave, static_cast<Slot>(ray.item.slot));
  const Vec3f direction = d * (1.0f / whole);
  const float end = to_end ? medium_end(context.scene, ray.item.origin, direction) : kInfinity;
  const MediumRay stretch =
      make_medium_ray(context, ray.state.flags, lambda, ray.item.origin, direction, min(whole * t, end));
  PathWeights weights{Quad(1.0f), Quad(1.0f), Quad(1.0f)};
  const MediumEstimator estimator = context.transport.medium_estimator;
  bool open = true;
  if (stretch.has(kMediumHomogeneous)) {
    pass_homogeneous(stretch, to_end && ray.state.target_medium != kNone, weights);
  } else if (estimator == MediumEstimator::kMarching) {
    pass_by_marching(stretch, ray.random, wave.stats.collisions, weights);
  } else {
    open =
        pass_null_collisions(stretch, ray.random, estimator == MediumEstimator::kDelta, wave.stats.collisions, weights);
  }
  weights.beta = weights.beta * Quad(ray.item.contribution);
  weights.r_u = weights.r_u * Quad(ray.state.r_u);
  weights.r_l = weights.r_l * Quad(ray.state.r_l);
  weights.rescale();
  ray.item.contribution = to_spectrum(weights.beta);
  ray.state.r_u = to_spectrum(weights.r_u);
  ray.state.r_l = to_spectrum(weights.r_l);
  return open;
}

/// Lets the light pass the surface that lane `at` of the packet has hit; the ray then begins behind it.
bool pass_surface(const StageContext& context, const Wave& wave, const RayPacket& packet, int at, ShadowRay& ray) {
  const SceneView& scene = context.scene;
  const Vec3f d = ray.item.direction;
  const Vec3f normal{packet.normal_x[at], packet.normal_y[at], packet.normal_z[at]};
  const bool behind = dot(normal, d) > 0.0f;
  const ShapeRecord<Scalar> shape = gather_rows<Scalar>(scene.shapes, packet.shape[at]);
  // The camera sees past hidden lights, and photons' shadow rays go to the camera.
  const bool hidden = context.photons != nullptr && context.transport.hide_emitters && shape.light != kNone;
  if (!hidden && !may_pass(scene, shape.material, behind)) return false;
  const Vec3f target = ray.item.origin + d;
  const float u = packet.u[at], v = packet.v[at];
  const auto y = surface_point<Scalar, true>(scene, shape, packet.primitive[at], u, v,
                                             ray.item.origin + d * packet.t_far[at], packet.instance[at]);
  PanePassage<Scalar> passage;
  if (hidden) {
    passage = {Spectrum4(1.0f), 1.0f};
  } else if ((scene.materials[shape.material].flags & kComposite) == 0) {
    const Spectrum4 lambda = lane_wavelengths(scene, wave, static_cast<Slot>(ray.item.slot));
    passage = pane_passage(scene, shape.material, dot(y.ns, d) / length(d), lambda);
  } else {
    passage.probability =
        passing_share(scene, shape.material, behind, {y.uv, packet.shape[at], packet.primitive[at], u, v, y.p});
    passage.share = Spectrum4(passage.probability);
  }
  if (!(passage.probability > 0.0f)) return false;
  ray.item.contribution = ray.item.contribution * passage.share;
  // The path, by BSDF sampling, passes with that probability; light sampling with certainty.
  ray.state.r_u = ray.state.r_u * passage.probability;
  const RayBehind<Scalar> behind_it = ray_behind<Scalar>(scene, y, shape.boundary, d, ray.state.flags);
  ray.state.flags = behind_it.flags;
  ray.item.origin = behind_it.origin;
  ray.item.direction = target - ray.item.origin;
  return true;
}

/// Adds what has arrived to its path.
void pay(const StageContext& context, Wave& wave, const ShadowRay& ray) {
  Quad r_u(ray.state.r_u);
  const std::uint32_t end = ray.state.target_medium;
  if (end != kNone) {
    // A point in a medium: the path would have to collide there.
    if (ray.state.flags >> kRayMediumShift != end) return;
    const Spectrum4 lambda = lane_wavelengths(context.scene, wave, static_cast<Slot>(ray.item.slot));
    const Vec3f p = ray.item.origin + ray.item.direction;
    r_u = r_u * collision_density(make_medium_ray(context, ray.state.flags, lambda, p, {0, 0, 1}, 0.0f), p);
  }
  const float by_light = lane_mean(context.scene, Quad(ray.state.r_l)),
              by_path = lane_mean(context.scene, r_u) * ray.state.pdf_ratio;
  const Quad found = Quad(ray.item.contribution) * (power_heuristic(by_light, by_path) / by_light);
  count_arrival(wave, ray.item.light, found);
  add_radiance(wave, static_cast<Slot>(ray.item.slot), found, ray.item.light);
}

/// Lets ray `i`, which lane `at` of the packet has traced, go on; returns whether it does, as ray `to` of the next
/// round.
bool follow_ray(const StageContext& context, Wave& wave, const RayPacket& packet, int at, int i, int round, int to) {
  ShadowRay ray = load_ray(context, wave, i, round);
  if (packet.shape[at] == kNone) {
    if (pass_medium(context, wave, ray, 1.0f, true)) pay(context, wave, ray);
    return false;
  }
  // What the surface lets pass is known sooner than what the medium does.
  ShadowRay behind = ray;
  if (!pass_surface(context, wave, packet, at, behind)) return false;
  ray.item.contribution = behind.item.contribution;
  ray.state.r_u = behind.state.r_u;
  if (!pass_medium(context, wave, ray, packet.t_far[at], false)) return false;
  ray.item.origin = behind.item.origin;
  ray.item.direction = behind.item.direction;
  ray.state.flags = behind.state.flags;
  if (!is_finite(ray.item.direction)) return false;
  wave.shadows.store<Scalar>(to, ray.item);
  wave.transmittances.store<Scalar>(to, ray.state);
  return true;
}

/// Follows all rays to the next surface, or to their ends. Those that go on stand at the front of the columns then;
/// returns how many.
template <class L> int follow(const StageContext& context, Wave& wave, int rays, int round) {
  int going = 0;
  trace_packets(
      context.scene, wave, rays, RayRecorder::Query::kNearest,
      [&](int first, int count, RayPacket& packet) {
        for_tiles<L>(count, [&](int at, int) {
          pack_shadow_rays<L>(wave, first + at, packet, at);
          store(packet.shape + at, Uint<L>(kNone));
        });
      },
      [&](int first, int count, const RayPacket& packet) {
        for (int i = 0; i < count; ++i) going += follow_ray(context, wave, packet, i, first + i, round, going) ? 1 : 0;
      });
  return going;
}

}  // namespace

template <class L> void transmittance(const StageContext& context, Wave& wave) noexcept {
  if (wave.shadow_count == 0) return;
  StageTimer timer(wave.stats, Stage::kTransmittance);
  timer.count(wave.shadow_count, kPacketWidth);
  count_shadow_rays(wave);
  int rays = wave.shadow_count;
  for (int round = 0; rays > 0 && round < kMostCrossings; ++round) rays = follow<L>(context, wave, rays, round);
  wave.shadow_count = 0;
}

SHEAF_INSTANTIATE_STAGE(transmittance);

}  // namespace sheaf

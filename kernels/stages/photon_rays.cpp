// Stage: photon rays. Emits photons from the lights, which are selected in proportion to their power.
//
// Photons carry flux instead of radiance. As for camera paths, the maximum lane of their throughput starts at 1, so
// that Russian roulette treats both alike. RadianceState::weight holds the flux of that lane, W. The random numbers are
// those of one long sequence of samples (kPhotonPixel).
#include "core/sampling/sampler.h"
#include "core/soa/lane_array.h"
#include "kernels/lights/light_emit.h"
#include "kernels/photons/light_task.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/stage_list.h"
#include "kernels/stages/start_medium.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Photons of the task, with their indices among all photons.
template <class L> struct PhotonNumbers {
  typename L::Uint in_task;
  typename L::Uint low, high;  ///< halves of the index
};

template <class L> PhotonNumbers<L> take_numbers(LightTask& task, int count) {
  LaneArray<Uint<L>> low(Uint<L>(0u)), high(Uint<L>(0u));
  PhotonNumbers<L> out;
  out.in_task = Uint<L>(static_cast<std::uint32_t>(task.emitted())) + L::index();
  for (int lane = 0; lane < count; ++lane, task.advance()) {
    low[lane] = static_cast<std::uint32_t>(task.next());
    high[lane] = static_cast<std::uint32_t>(task.next() >> 32);
  }
  out.low = low.load();
  out.high = high.load();
  return out;
}

/// Moves light from infinity to where it enters the outer medium, if no surface bounds that medium.
template <class L>
SHEAF_INLINE Vec3<L> enter_outer_medium(const SceneView& scene, Vec3<L> origin, Vec3<L> direction,
                                        Mask<L> from_outside) {
  using F = Float<L>;
  if (scene.media.outer_medium == 0 || !(scene.media.outer_radius < kInfinity)) return origin;
  const Vec3<L> from = origin - broadcast<L>(scene.center);
  const F b = dot(from, direction), square = b * b - dot(from, from) + F(sqr(scene.media.outer_radius));
  const auto meets = from_outside & (square > F(0.0f));
  const F t = -b - sqrt(select(meets, square, F(0.0f)));
  return select<L>(meets, origin + direction * t, origin);
}

template <class L, ColorMode kMode>
SHEAF_INLINE std::uint32_t emit_tile(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const PhotonNumbers<L> numbers = take_numbers<L>(context.light_task(), count);
  PathState<L> path;
  path.pixel = U(kPhotonPixel) + numbers.high;
  path.sample = numbers.low;
  path.eta_scale = F(1.0f);
  path.depth_and_dimension = U(kOneDimension);  // the light uses the first dimension
  const auto number = [&](SampleBlock block) {
    return draw<L>(context.sampler, path.pixel, path.sample, U(0u), block);
  };
  const Random4<L> a = number(SampleBlock::kLight), b = number(SampleBlock::kScatter);
  const Random4<L> c = number(SampleBlock::kWavelength);
  const F one = c.x;
  if constexpr (kMode == ColorMode::kSpectral)
    scatter_wavelength_samples<L>(wave, slots, count,
                                  context.wavelength_sample < 0.0f ? one : F(context.wavelength_sample));
  const F time = sample_shutter<L>(scene.motion.shutter_ramp, c.z);
  if (scene.motion.any()) scatter_times<L>(wave, slots, count, time);
  // Select a light and emit the photon
  const LightChoice<L> choice = choose_light_by_power<L>(scene, a.x);
  PhotonEmission<L> photon =
      emit_photon<L, kMode>(scene, choice, a, b, time, shading_wavelengths<L, kMode>(wave, slots));
  if constexpr (kMode == ColorMode::kRgb) photon.flux.c3 = F(0.0f);
  const F brightest = max_component(photon.flux);
  auto good = photon.valid & (brightest > F(0.0f)) & L::first(count);
  const F scale = select(good, brightest, F(1.0f));
  path.beta = photon.flux * (F(1.0f) / scale);

  // Write the ray
  RayState<L> ray;
  ray.direction = photon.direction;
  ray.origin =
      enter_outer_medium<L>(scene, photon.origin, photon.direction, !(choice.light < U(scene.lights.bounded_count)));
  ray.t_max = F(kInfinity);
  ray.flags = U(0u);
  if (keeps_distance_since_vertex(context))
    for (int lane = 0; lane < count; ++lane) wave.distance_since_vertex[slots[lane]] = 0.0f;
  if (scene.needs_transmittance) {
    wave.rescaled_pdfs.scatter<L>(slots, count, {Spectrum<L>(F(1.0f)), Spectrum<L>(F(1.0f))});
    if (scene.color == ColorMode::kRgb) ray.flags = min(to_uint(one * F(3.0f)), U(2u)) << kRayHeroShift;
    // Camera paths with the same four wavelengths sample distances by the first. Stored photons must not use the first
    // as well, or the pdf of both together would not be the product of their means over the lanes.
    else if (context.light_task().stores_photons())
      ray.flags = min(to_uint(c.y * F(4.0f)), U(3u)) << kRayHeroShift;
    const U medium = start_medium<L>(scene, wave, ray.origin, ray.direction, time, good);
    ray.flags |= medium << kRayMediumShift;
    // The point was sampled in the box of an emissive medium, but lies outside of the medium.
    good = good & ((photon.medium == U(kNone)) | (photon.medium == medium));
  }
  wave.rays.scatter<L>(slots, count, ray);
  wave.paths.scatter<L>(slots, count, path);
  wave.radiance.scatter<L>(slots, count, {Spectrum<L>(F(0.0f)), F(0.0f), U(0u), scale, numbers.in_task});
  return mask_bits(good);
}

}  // namespace

template <class L> void photon_rays(const StageContext& context, Wave& wave) noexcept {
  if (context.scene.lights.count == 0) return;
  const int starting = std::min(wave.free.size(), context.light_task().left());
  if (starting <= 0) return;
  StageTimer timer(wave.stats, stage_named<L>("photon_rays"));
  timer.count(starting, L::width);
  with_color_mode(context.scene, [&]<ColorMode kMode>() {
    for_tiles<L>(starting, [&](int, int count) {
      Slot slots[L::width] = {};
      for (int lane = 0; lane < count; ++lane) slots[lane] = wave.free.pop();
      const std::uint32_t good = emit_tile<L, kMode>(context, wave, slots, count);
      wave.active.push(slots, good);
      wave.finished.push(slots, ~good & ((1u << count) - 1u));
      wave.stats.rays.light += static_cast<std::uint64_t>(std::popcount(good));
    });
  });
}

SHEAF_INSTANTIATE_STAGE(photon_rays);

}  // namespace sheaf

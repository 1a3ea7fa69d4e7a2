// Stage: camera rays. Pixel positions by filter importance sampling; see scene/filter.h.
#include "core/sampler.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"

namespace sheaf {

namespace {

/// Pixel and sample of consecutive camera samples of a task.
class SampleCursor {
 public:
  SampleCursor(const TileSamples& task, int index) : task_(task) {
    const int pixel = index / static_cast<int>(task.sample_count);
    sample_ = static_cast<std::uint32_t>(index) - static_cast<std::uint32_t>(pixel) * task.sample_count;
    x_ = task.pixels.x0 + pixel % task.pixels.width();
    y_ = task.pixels.y0 + pixel / task.pixels.width();
  }
  std::uint32_t x() const { return static_cast<std::uint32_t>(x_); }
  std::uint32_t y() const { return static_cast<std::uint32_t>(y_); }
  std::uint32_t sample() const { return task_.first_sample + sample_; }
  void next() {
    if (++sample_ < task_.sample_count) return;
    sample_ = 0;
    if (++x_ < task_.pixels.x1) return;
    x_ = task_.pixels.x0;
    ++y_;
  }

 private:
  const TileSamples& task_;
  std::uint32_t sample_;
  int x_, y_;
};

/// A pinhole leaves a number of the camera's block free, which is spread together with the place in the pixel: then
/// colour noise is low where the pixel's parts differ.
template <class L>
SHEAF_INLINE void start_wavelengths(const SceneView& scene, Wave& wave, const Slot* slots, int count,
                                    const ThroughputState<L>& path, const Random4<L>& camera) {
  const bool lens = scene.camera.has_lens();
  alignas(kSimdAlignment) float u[L::width];
  store(u, lens ? draw<L>(scene.sampler, path.pixel, path.sample, Uint<L>(0u), SampleBlock::kWavelength).x : camera.z);
  for (int lane = 0; lane < count; ++lane) wave.heroes[slots[lane]] = u[lane];
}

/// The state that only scenes with media or surfaces that let shadow rays pass have. Returns RayState::flags.
template <class L>
SHEAF_INLINE Uint<L> start_in_medium(const SceneView& scene, Wave& wave, const Slot* slots, int count,
                                     const ThroughputState<L>& path) {
  using F = typename L::Float;
  using U = typename L::Uint;
  wave.probabilities.scatter<L>(slots, count, {Spectrum<L>(F(1.0f)), Spectrum<L>(F(1.0f))});
  for (int lane = 0; lane < count; ++lane) wave.travelled[slots[lane]] = 0.0f;
  const U medium(scene.camera_medium << kRayMediumShift);
  if (scene.color == ColorMode::kSpectral) return medium;
  const F u = draw<L>(scene.sampler, path.pixel, path.sample, U(0u), SampleBlock::kWavelength).x;
  return medium | (min(to_uint(u * F(3.0f)), U(2u)) << kRayHeroShift);
}

template <class L>
SHEAF_INLINE void start_tile(const SceneView& scene, Wave& wave, SampleCursor& cursor, const Slot* slots, int count,
                             std::uint32_t flags) {
  using F = typename L::Float;
  using U = typename L::Uint;
  alignas(kSimdAlignment) std::uint32_t x[L::width], y[L::width], sample[L::width];
  for (int lane = 0; lane < L::width; ++lane) {
    x[lane] = cursor.x();
    y[lane] = cursor.y();
    sample[lane] = cursor.sample();
    if (lane < count - 1) cursor.next();
  }
  if (count > 0) cursor.next();
  U px, py;
  ThroughputState<L> throughput;
  load(x, px);
  load(y, py);
  load(sample, throughput.sample);
  throughput.pixel = py * U(static_cast<std::uint32_t>(wave.task.frame_width)) + px;
  // The fourth lane is no colour in RGB mode: it starts at 0 and stays there, whatever BSDFs do to it.
  throughput.beta = {F(1.0f), F(1.0f), F(1.0f), F(scene.color == ColorMode::kSpectral ? 1.0f : 0.0f)};
  throughput.eta_scale = F(1.0f);
  throughput.progress = U(0u);

  const auto u = draw<L>(scene.sampler, throughput.pixel, throughput.sample, U(0u), SampleBlock::kCamera);
  if (scene.color == ColorMode::kSpectral) start_wavelengths<L>(scene, wave, slots, count, throughput, u);
  const auto dx = scene.filter->sample<L>(u.x), dy = scene.filter->sample<L>(u.y);
  const F film_x = to_float(px) + F(0.5f) + dx.position, film_y = to_float(py) + F(0.5f) + dy.position;
  const Vec2<L> lens = scene.camera.has_lens() ? square_to_disk<L>(u.z, u.w) : Vec2<L>{F(0.0f), F(0.0f)};
  const CameraRay<L> from_camera = scene.camera.ray<L>(film_x, film_y, lens.x, lens.y);
  RayState<L> ray;
  ray.origin = from_camera.origin;
  ray.direction = from_camera.direction;
  ray.t_max = from_camera.t_max;
  ray.flags = U(flags);
  if (scene.has_transparency) ray.flags |= start_in_medium<L>(scene, wave, slots, count, throughput);

  RadianceState<L> radiance;
  radiance.scatter_pdf = F(0.0f);
  radiance.normal = U(0u);
  radiance.weight = dx.weight * dy.weight;
  radiance.task_sample = U(static_cast<std::uint32_t>(wave.next_sample)) + L::index();
  wave.rays.scatter<L>(slots, count, ray);
  wave.throughput.scatter<L>(slots, count, throughput);
  wave.radiance.scatter<L>(slots, count, radiance);
}

}  // namespace

template <class L> void camera_rays(const SceneView& scene, Wave& wave) noexcept {
  const int starting = std::min(wave.free.size(), wave.task.total() - wave.next_sample);
  if (starting <= 0) return;
  StageTimer timer(wave.stats, Stage::kCameraRays);
  timer.count(starting, L::width);
  const std::uint32_t flags = kRayFromCamera | (scene.integrator.max_depth == 1 ? kRayLast : 0u);
  SampleCursor cursor(wave.task, wave.next_sample);
  for_tiles<L>(starting, [&](int, int count) {
    Slot slots[L::width] = {};
    for (int lane = 0; lane < count; ++lane) slots[lane] = wave.free.pop();
    start_tile<L>(scene, wave, cursor, slots, count, flags);
    for (int lane = 0; lane < count; ++lane) wave.active.push(slots[lane]);
    wave.next_sample += count;
  });
  wave.stats.rays.camera += static_cast<std::uint64_t>(starting);
}

SHEAF_INSTANTIATE_STAGE(camera_rays);

}  // namespace sheaf

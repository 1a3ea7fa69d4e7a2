// Stage: camera rays. Importance-samples positions in the pixel by the pixel filter (PBR 8.8; scene/tables/filter.h)
// and generates camera rays of throughput beta = 1 (times CameraView::weight) and rescaled pdfs r_u = r_l = 1.
#include "core/sampling/sampler.h"
#include "core/soa/lane_array.h"
#include "kernels/film/camera_task.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/moving_camera.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Whether a camera has a lens. Additional cameras are assumed to have one.
bool has_lens(const SceneView& scene) { return scene.sensor.camera.has_lens() || scene.sensor.more_camera_count > 0; }

/// Draws the wavelengths. Pinholes leave one number of the camera's block unused. It is stratified jointly with the
/// position in the pixel, which lowers color noise in pixels whose parts differ.
template <class L>
SHEAF_INLINE void start_wavelengths(const StageContext& context, Wave& wave, const Slot* slots, int count,
                                    const PathState<L>& path, const Random4<L>& camera) {
  Float<L> u = camera.z;
  if (context.wavelength_sample >= 0.0f)
    u = Float<L>(context.wavelength_sample);
  else if (has_lens(context.scene))
    u = draw<L>(context.sampler, path.pixel, path.sample, Uint<L>(0u), SampleBlock::kWavelength, {}, kNumberX).x;
  scatter_wavelength_samples<L>(wave, slots, count, u);
}

/// Draws the times of paths; 0 in static scenes.
template <class L>
SHEAF_INLINE Float<L> start_time(const StageContext& context, Wave& wave, const Slot* slots, int count,
                                 const PathState<L>& path) {
  if (!context.scene.motion.any()) return Float<L>(0.0f);
  const Float<L> u =
      draw<L>(context.sampler, path.pixel, path.sample, Uint<L>(0u), SampleBlock::kWavelength, {}, kNumberY).y;
  const Float<L> time = sample_shutter<L>(context.scene.motion.shutter_ramp, u);
  scatter_times<L>(wave, slots, count, time);
  return time;
}

/// The ray at `time` of the camera whose column of the film contains the position.
template <class L>
SHEAF_INLINE CameraRay<L> camera_ray(const SceneView& scene, Float<L> x, Float<L> y, const Random4<L>& u,
                                     Float<L> time) {
  using F = Float<L>;
  const auto of = [&](const Camera& camera, std::uint32_t index, F across) SHEAF_LAMBDA_INLINE {
    const Vec2<L> lens = camera.has_lens() ? square_to_disk<L>(u.z, u.w) : Vec2<L>{F(0.0f), F(0.0f)};
    const CameraRay<L> ray = camera.ray<L>(across, y, lens.x, lens.y);
    return scene.motion.cameras == nullptr ? ray : move_camera_ray<L>(camera_motion<L>(scene, index, time), ray);
  };
  CameraRay<L> ray = of(scene.sensor.camera, 0, x);
  for (std::uint32_t i = 0; i < scene.sensor.more_camera_count; ++i) {
    const F begin(static_cast<float>(i + 1) * scene.sensor.column_width);
    const auto here = x >= begin;
    if (!any(here)) break;
    const CameraRay<L> other = of(scene.sensor.more_cameras[i], i + 1, x - begin);
    ray.origin = select<L>(here, other.origin, ray.origin);
    ray.direction = select<L>(here, other.direction, ray.direction);
    ray.t_max = select(here, other.t_max, ray.t_max);
  }
  return ray;
}

/// The media in which rays start that have a position `x` across the film, if the media depend on it or on the time.
template <class L> [[gnu::noinline]] Uint<L> camera_media(const SceneView& scene, Float<L> x, Float<L> time) {
  using F = Float<L>;
  using U = Uint<L>;
  U medium(scene.media.camera_medium);
  for (std::uint32_t i = 0; i < scene.media.camera_medium_count; ++i) {
    const CameraMediumRow& row = scene.media.camera_media[i];
    const F begin(row.camera == 0 ? -kInfinity : static_cast<float>(row.camera) * scene.sensor.column_width);
    medium = select((x >= begin) & (time >= F(row.time)), U(row.medium), medium);
  }
  return medium;
}

/// Initializes the state for scenes with SceneView::needs_transmittance. Returns the medium and, in RGB mode, a random
/// hero lane as bits of RayState::flags. `x`: position across the film.
template <class L>
SHEAF_INLINE Uint<L> start_in_medium(const StageContext& context, Wave& wave, const Slot* slots, int count,
                                     const PathState<L>& path, Float<L> x, Float<L> time) {
  using F = typename L::Float;
  using U = typename L::Uint;
  wave.rescaled_pdfs.scatter<L>(slots, count, {Spectrum<L>(F(1.0f)), Spectrum<L>(F(1.0f))});
  U medium(context.scene.media.camera_medium);
  if (context.scene.media.camera_medium_count > 0) [[unlikely]]
    medium = camera_media<L>(context.scene, x, time);
  medium = medium << kRayMediumShift;
  if (context.scene.color == ColorMode::kSpectral) return medium;
  const F u = draw<L>(context.sampler, path.pixel, path.sample, U(0u), SampleBlock::kWavelength, {}, kNumberX).x;
  return medium | (min(to_uint(u * F(3.0f)), U(2u)) << kRayHeroShift);
}

/// Stores the offsets of samples from their pixels' centers, for the film.
template <class L>
SHEAF_INLINE void remember_offsets(CameraTask& task, Uint<L> sample, int count, Float<L> x, Float<L> y) {
  const LaneArray<Uint<L>> index(sample);
  const LaneArray<Float<L>> xs(x), ys(y);
  for (int lane = 0; lane < count; ++lane) task.samples.offset(index[lane]) = {xs[lane], ys[lane]};
}

/// Stores the filter weights of samples with the surfaces that they will hit.
template <class L> SHEAF_INLINE void remember_weights(CameraTask& task, Uint<L> sample, int count, Float<L> weight) {
  const LaneArray<Uint<L>> index(sample);
  const LaneArray<Float<L>> weights(weight);
  for (int lane = 0; lane < count; ++lane) task.samples.surface(index[lane]).weight = weights[lane];
}

template <class L>
SHEAF_INLINE void start_tile(const StageContext& context, Wave& wave, const Slot* slots, int count,
                             std::uint32_t flags) {
  using F = typename L::Float;
  using U = typename L::Uint;
  CameraTask& task = context.camera_task();
  LaneArray<F> x, y;
  LaneArray<U> pixel, sample;
  RadianceState<L> radiance;
  radiance.task_sample = U(static_cast<std::uint32_t>(task.cursor.index)) + L::index();
  // Take samples from the task; unused lanes repeat the last one
  for (int lane = 0; lane < L::width; ++lane) {
    const int last = std::min(lane, count - 1);
    pixel[lane] = lane < count ? task.pixel() : pixel[last];
    sample[lane] = lane < count ? task.sample() : sample[last];
    x[lane] = lane < count ? static_cast<float>(task.x()) : x[last];
    y[lane] = lane < count ? static_cast<float>(task.y()) : y[last];
    if (lane < count) task.advance();
  }
  PathState<L> path;
  path.sample = sample.load();
  path.pixel = pixel.load();
  // In RGB mode the fourth lane is unused: it starts at 0 and stays 0, whatever BSDFs do.
  const F weight(context.scene.sensor.camera.weight);
  path.beta = {weight, weight, weight, context.scene.color == ColorMode::kSpectral ? weight : F(0.0f)};
  path.eta_scale = F(1.0f);
  path.depth_and_dimension = U(0u);

  // Sample wavelengths and the position in the pixel
  const bool spreads_z = has_lens(context.scene) || context.scene.color == ColorMode::kSpectral;
  const auto u = draw<L>(context.sampler, path.pixel, path.sample, U(0u), SampleBlock::kCamera, {},
                         spreads_z ? kAllNumbers : kNumberX | kNumberY);
  if (context.scene.color == ColorMode::kSpectral) start_wavelengths<L>(context, wave, slots, count, path, u);
  const auto dx = context.scene.sensor.filter->sample<L>(u.x), dy = context.scene.sensor.filter->sample<L>(u.y);
  remember_offsets<L>(task, radiance.task_sample, count, dx.position, dy.position);
  const F film_x = x.load() + F(0.5f) + dx.position, film_y = y.load() + F(0.5f) + dy.position;
  const F time = start_time<L>(context, wave, slots, count, path);
  const CameraRay<L> from_camera = camera_ray<L>(context.scene, film_x, film_y, u, time);
  // Generate the ray
  RayState<L> ray;
  ray.origin = from_camera.origin;
  ray.direction = from_camera.direction;
  ray.t_max = from_camera.t_max;
  ray.flags = U(flags);
  if (keeps_distance_since_vertex(context))
    for (int lane = 0; lane < count; ++lane) wave.distance_since_vertex[slots[lane]] = 0.0f;
  if (context.samples_guide())
    for (int lane = 0; lane < count; ++lane) wave.guide_references[slots[lane]] = 0.0f;
  if (context.compares_candidates())
    for (int lane = 0; lane < count; ++lane) wave.moments.row(slots[lane]) = {};
  if (context.scene.needs_transmittance)
    ray.flags |= start_in_medium<L>(context, wave, slots, count, path, film_x, time);

  radiance.scatter_pdf = F(0.0f);
  radiance.normal = U(0u);
  radiance.weight = dx.weight * dy.weight;
  if (task.samples.has_surfaces()) remember_weights<L>(task, radiance.task_sample, count, radiance.weight);
  wave.rays.scatter<L>(slots, count, ray);
  wave.paths.scatter<L>(slots, count, path);
  wave.radiance.scatter<L>(slots, count, radiance);
}

}  // namespace

template <class L> void camera_rays(const StageContext& context, Wave& wave) noexcept {
  const int starting = std::min(wave.free.size(), context.camera_task().left());
  if (starting <= 0) return;
  StageTimer timer(wave.stats, stage_named<L>("camera_rays"));
  timer.count(starting, L::width);
  const std::uint32_t flags = kRayFromCamera | (context.max_depth == 1 ? kRayLast : 0u);
  for_tiles<L>(starting, [&](int, int count) {
    Slot slots[L::width] = {};
    for (int lane = 0; lane < count; ++lane) slots[lane] = wave.free.pop();
    start_tile<L>(context, wave, slots, count, flags);
    for (int lane = 0; lane < count; ++lane) wave.active.push(slots[lane]);
  });
  wave.stats.rays.camera += static_cast<std::uint64_t>(starting);
}

SHEAF_INSTANTIATE_STAGE(camera_rays);

}  // namespace sheaf

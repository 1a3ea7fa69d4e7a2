// Stage: AOVs. Writes the layers of the first surface of each camera path to the task's samples, weighted by the pixel
// filter as radiance is. Mirrors and glass count as surfaces; null interfaces, masks that the ray passes and hidden
// lights do not. Paths that a medium scatters first, and paths that hit nothing, leave zeros.
#include "core/soa/lane_array.h"
#include "kernels/film/camera_task.h"
#include "kernels/stages/moving_camera.h"
#include "kernels/stages/stage_list.h"
#include "kernels/stages/surface_albedo.h"
#include "kernels/wave/load_bsdf.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

namespace {

/// Lanes of a tile whose paths are at their first surface, with their samples.
template <class L> struct SampleLanes {
  std::uint32_t lanes;
  typename L::Float weight;  ///< of the pixel filter
  float* sample[L::width];

  /// Writes values times the filter weight to the channels from `first` on. Non-finite values become 0.
  template <std::size_t N> SHEAF_INLINE void put_words(int first, const Float<L> (&values)[N]) const {
    for (std::size_t k = 0; k < N; ++k) {
      const Float<L> value = values[k] * weight;
      const LaneArray<Float<L>> words(select(is_finite(value), value, Float<L>(0.0f)));
      for_each_lane(lanes,
                    [&](int lane) SHEAF_LAMBDA_INLINE { sample[lane][first + static_cast<int>(k)] = words[lane]; });
    }
  }
  SHEAF_INLINE void put(int first, const Vec3<L>& value) const {
    if (first >= 0) put_words(first, {value.x, value.y, value.z});
  }
};

/// Stores the shapes that the samples hit.
template <class L>
SHEAF_INLINE void put_surfaces(SampleBuffer& samples, std::uint32_t lanes, Uint<L> task_sample, Uint<L> shape) {
  const LaneArray<Uint<L>> index(task_sample & Uint<L>(~kTransparent)), shapes(shape);
  for_each_lane(lanes, [&](int lane) SHEAF_LAMBDA_INLINE { samples.surface(index[lane]).shape = shapes[lane]; });
}

/// The lanes whose rays come straight from the camera, with their samples.
template <class L>
SHEAF_INLINE SampleLanes<L> first_surfaces(SampleBuffer& samples, const RadianceState<L>& radiance, Uint<L> flags,
                                           int count) {
  SampleLanes<L> out;
  out.weight = radiance.weight;
  out.lanes = mask_bits(((flags & Uint<L>(kRayFromCamera)) != Uint<L>(0u)) & L::first(count));
  const LaneArray<Uint<L>> index(radiance.task_sample & Uint<L>(~kTransparent));
  for_each_lane(out.lanes, [&](int lane) SHEAF_LAMBDA_INLINE { out.sample[lane] = samples[index[lane]]; });
  return out;
}

/// The values of seen_by(camera, index) for the cameras whose columns of the film contain the pixels.
template <class L, class SeenBy>
SHEAF_INLINE Float<L> by_camera(const SceneView& scene, const CameraTask& task, Uint<L> pixel, SeenBy&& seen_by) {
  using F = Float<L>;
  F value = seen_by(scene.sensor.camera, 0u);
  if (scene.sensor.more_camera_count == 0) return value;
  const LaneArray<Uint<L>> pixels(pixel);
  const F x = make_lanes<F>([&](int lane) { return static_cast<float>(task.frame().x(pixels[lane])) + 0.5f; });
  for (std::uint32_t i = 0; i < scene.sensor.more_camera_count; ++i)
    value = select(x > F(static_cast<float>(i + 1) * scene.sensor.column_width),
                   seen_by(scene.sensor.more_cameras[i], i + 1), value);
  return value;
}

/// Depth along the axis of the camera, m. Cameras without an axis: distance.
template <class L>
SHEAF_INLINE Float<L> depth_of(const SceneView& scene, const CameraTask& task, Uint<L> pixel, Vec3<L> p,
                               Float<L> time) {
  return by_camera<L>(scene, task, pixel, [&](const Camera& camera, std::uint32_t index) SHEAF_LAMBDA_INLINE {
    const Vec3<L> from = camera_rest_point<L>(scene, index, p, time) - broadcast<L>(camera.origin);
    const float scale = length(camera.z_axis);
    return scale > 0.0f ? dot(from, broadcast<L>(camera.z_axis / scale)) : length(from);
  });
}

/// Positions at time `then` of the points `p` of surfaces that were hit at time `now`, both in [0, 1].
template <class L>
Vec3<L> surface_at(const SceneView& scene, const HitState<L>& hit, Vec3<L> p, Float<L> now, Float<L> then) {
  using U = Uint<L>;
  const auto instanced = hit.instance != U(kNone);
  const bool any_deforms = scene.motion.deformations != nullptr;
  const bool any_placed =
      scene.geometry.instances != nullptr && (scene.motion.instances != nullptr || any_deforms) && any(instanced);
  const auto placed = [&](Float<L> time) SHEAF_LAMBDA_INLINE {
    const auto row = gather_rows<L>(scene.geometry.instances, select(instanced, hit.instance, U(0u)));
    return placement_at<L>(scene.motion, row, hit.instance, instanced, time).placed;
  };
  Vec3<L> at = any_placed ? select<L>(instanced, placed(now).object_point(p), p) : p;
  // Curves that deform
  ShapeRecord<L> shape{};
  Mask<L> deforms(false);
  if (any_deforms) {
    shape = gather_rows<L>(scene.geometry.shapes, hit.shape);
    deforms = (shape.flags >> kDeformationShift) != U(0u);
    const Mask<L> curve = deforms & (shape.kind != U(static_cast<std::uint32_t>(ShapeKind::kMesh)));
    if (any(curve))
      at = select<L>(curve, follow_curve<L>(scene, shape, curve, hit.primitive, hit.u, at, now, then), at);
    deforms = deforms & !curve;
  }
  if (any_placed) at = select<L>(instanced, placed(then).point(at), at);
  // Triangles of meshes that deform
  if (!any_deforms || !any(deforms)) return at;
  return select<L>(deforms, surface_point<L>(scene, shape, hit.primitive, hit.u, hit.v, p, hit.instance, then).p, at);
}

/// Writes the displacements on the film, to the right and upwards in pixels, over the shutter interval. 0 for points
/// that a camera does not see at its start or its end.
template <class L>
[[gnu::noinline]] void put_motion(const SceneView& scene, const CameraTask& task, const Wave& wave, const Slot* slots,
                                  Vec3<L> p, int channel, const SampleLanes<L>& out) {
  using F = Float<L>;
  if (!scene.motion.any()) return out.put_words(channel, {F(0.0f), F(0.0f)});
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const Uint<L> pixel = wave.paths.gather<L>(slots).pixel;
  const F now = path_times<L>(scene, wave, slots), open(0.0f), close(1.0f);
  const Vec3<L> first = surface_at<L>(scene, hit, p, now, open), last = surface_at<L>(scene, hit, p, now, close);
  const auto view = [&](const Camera& camera, std::uint32_t index, Vec3<L> q, F time) SHEAF_LAMBDA_INLINE {
    return camera.view<L>(camera_rest_point<L>(scene, index, q, time), F(0.0f), F(0.0f));
  };
  const F right = by_camera<L>(scene, task, pixel, [&](const Camera& camera, std::uint32_t index) SHEAF_LAMBDA_INLINE {
    const CameraView<L> from = view(camera, index, first, open), to = view(camera, index, last, close);
    F step = to.film_x - from.film_x;
    // Panoramas of longitudes are periodic
    if (camera.is_panorama() && camera.rays != CameraRays::kEqualArea) {
      const F revolutions = step * F(camera.film_step.x);
      step = (revolutions - floor(revolutions + F(0.5f))) * F(1.0f / camera.film_step.x);
    }
    return select(from.valid & to.valid, step, F(0.0f));
  });
  const F up = by_camera<L>(scene, task, pixel, [&](const Camera& camera, std::uint32_t index) SHEAF_LAMBDA_INLINE {
    const CameraView<L> from = view(camera, index, first, open), to = view(camera, index, last, close);
    return select(from.valid & to.valid, from.film_y - to.film_y, F(0.0f));
  });
  out.put_words(channel, {right, up});
}

/// A point of the scene in world space.
template <class L> SHEAF_INLINE Vec3<L> world_point(const SceneView& scene, Vec3<L> p) {
  if (scene.origin == Vec3d()) return p;
  const Vec3f high = scene.origin.rounded(), low = (scene.origin - Vec3d(high)).rounded();
  return p + broadcast<L>(low) + broadcast<L>(high);
}

template <class L>
SHEAF_INLINE void put_uv(const SceneView& scene, const Wave& wave, const Slot* slots, const RayState<L>& ray,
                         int channel, const SampleLanes<L>& out) {
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, hit.shape);
  const auto y = surface_point<L, true>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                        hit.instance, path_times<L>(scene, wave, slots));
  out.put_words(channel, {y.uv.x, y.uv.y});
}

/// Writes all layers except the albedo, for any BSDF. Returns the lanes and samples for the albedo.
template <class L>
[[gnu::noinline]] SampleLanes<L> aov_tile(const StageContext& context, Wave& wave, const Slot* slots, int column,
                                          int count) {
  using F = Float<L>;
  const SceneView& scene = context.scene;
  CameraTask& task = context.camera_task();
  const AovChannels& channels = task.aovs();
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const RadianceState<L> radiance = wave.radiance.gather<L>(slots);
  SampleLanes<L> out = first_surfaces<L>(task.samples, radiance, ray.flags, count);
  if (out.lanes == 0) return out;
  const VertexItem<L> item = wave.vertices.load<L>(column);
  const Vec3<L> ng = select<L>(dot(item.ng, ray.direction) > F(0.0f), -item.ng, item.ng);
  out.put(channels[aov_named("normal")], select<L>(dot(item.ns, ng) < F(0.0f), -item.ns, item.ns));
  out.put(channels[aov_named("geometric_normal")], ng);
  out.put(channels[aov_named("position")], world_point<L>(scene, item.p));
  if (const int depth = channels[aov_named("depth")]; depth >= 0) {
    const Uint<L> pixel = wave.paths.gather<L>(slots).pixel;
    out.put_words(depth, {depth_of<L>(scene, task, pixel, item.p, path_times<L>(scene, wave, slots))});
  }
  if (const int uv = channels[aov_named("uv")]; uv >= 0) put_uv<L>(scene, wave, slots, ray, uv, out);
  if (const int motion = channels[aov_named("motion")]; motion >= 0)
    put_motion<L>(scene, task, wave, slots, item.p, motion, out);
  if (channels.has_surfaces())
    put_surfaces<L>(task.samples, out.lanes, radiance.task_sample, wave.hits.gather<L>(slots).shape);
  return out;
}

template <class L>
[[gnu::noinline]] void put_albedo(const StageContext& context, const Wave& wave, const Slot* slots,
                                  const SampleLanes<L>& out, const Spectrum<L>& albedo) {
  using F = Float<L>;
  Vec3<L> rgb{albedo.c0, albedo.c1, albedo.c2};
  if (context.scene.color == ColorMode::kSpectral)
    rgb = reflectance_to_rgb<L>(context.scene.spectral,
                                sample_wavelengths<L>(abs(gather_wavelength_samples<L>(wave, slots))), albedo);
  const auto unit = [](F value) SHEAF_LAMBDA_INLINE { return clamp(value, F(0.0f), F(1.0f)); };
  out.put(context.camera_task().aovs()[aov_named("albedo")], Vec3<L>{unit(rgb.x), unit(rgb.y), unit(rgb.z)});
}

}  // namespace

template <class L> void aovs(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("aovs"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!kIsPhaseFunction<Bsdf<L>>) {
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, L::width);
      for_tiles<L>(run.count, [&](int i, int count) {
        const Slot* slots = wave.sorted.data() + run.slot_begin + i;
        const int column = run.column_begin + i;
        const SampleLanes<L> out = aov_tile<L>(context, wave, slots, column, count);
        if (out.lanes == 0 || context.camera_task().aovs()[aov_named("albedo")] < 0) return;
        const Vec3<L> wo = wave.vertices.load<L>(column).wo;
        put_albedo<L>(context, wave, slots, out,
                      directional_albedo<L>(load_bsdf<L, Bsdf>(context.scene, wave, column), wo));
      });
    }
  });
}

SHEAF_INSTANTIATE_STAGE(aovs);

}  // namespace sheaf

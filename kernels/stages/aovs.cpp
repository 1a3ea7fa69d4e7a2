// Stage: AOVs. Writes the layers of the first surface of each camera path to the task's samples, weighted by the pixel
// filter as radiance is. Mirrors and glass count as surfaces; null interfaces, masks that the ray passes and hidden
// lights do not. Paths that a medium scatters first, and paths that hit nothing, leave zeros.
#include "kernels/film/camera_task.h"
#include "kernels/stages/stages.h"
#include "kernels/stages/surface_albedo.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"
#include "scene/tables/shape.h"

#include <bit>

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
      alignas(kSimdAlignment) float words[L::width];
      const Float<L> value = values[k] * weight;
      store(words, select(is_finite(value), value, Float<L>(0.0f)));
      for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
        const int lane = std::countr_zero(left);
        sample[lane][first + static_cast<int>(k)] = words[lane];
      }
    }
  }
  SHEAF_INLINE void put(int first, const Vec3<L>& value) const {
    if (first >= 0) put_words(first, {value.x, value.y, value.z});
  }
};

/// Stores the shapes that the samples hit.
template <class L>
SHEAF_INLINE void put_surfaces(SampleBuffer& samples, std::uint32_t lanes, Uint<L> task_sample, Uint<L> shape) {
  alignas(kSimdAlignment) std::uint32_t index[L::width], shapes[L::width];
  store(index, task_sample & Uint<L>(~kTransparent));
  store(shapes, shape);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int lane = std::countr_zero(lanes);
    samples.surface(index[lane]).shape = shapes[lane];
  }
}

/// The lanes whose rays come straight from the camera, with their samples.
template <class L>
SHEAF_INLINE SampleLanes<L> first_surfaces(SampleBuffer& samples, const RadianceState<L>& radiance, Uint<L> flags,
                                           int count) {
  SampleLanes<L> out;
  out.weight = radiance.weight;
  out.lanes = mask_bits(((flags & Uint<L>(kRayFromCamera)) != Uint<L>(0u)) & L::first(count));
  alignas(kSimdAlignment) std::uint32_t index[L::width];
  store(index, radiance.task_sample & Uint<L>(~kTransparent));
  for (std::uint32_t left = out.lanes; left != 0; left &= left - 1) {
    const int lane = std::countr_zero(left);
    out.sample[lane] = samples[index[lane]];
  }
  return out;
}

/// Depth along the axis of the camera whose column of the film contains the pixel, m. Cameras without an axis:
/// distance.
template <class L>
SHEAF_INLINE Float<L> depth_of(const SceneView& scene, const CameraTask& task, Uint<L> pixel, Vec3<L> p) {
  using F = Float<L>;
  const auto seen_by = [&](const Camera& camera) SHEAF_LAMBDA_INLINE {
    const Vec3<L> from = p - broadcast<L>(camera.origin);
    const float scale = length(camera.z_axis);
    return scale > 0.0f ? dot(from, broadcast<L>(camera.z_axis / scale)) : length(from);
  };
  F depth = seen_by(scene.sensor.camera);
  if (scene.sensor.more_camera_count == 0) return depth;
  alignas(kSimdAlignment) std::uint32_t pixels[L::width];
  alignas(kSimdAlignment) float column[L::width];
  store(pixels, pixel);
  for (int lane = 0; lane < L::width; ++lane) column[lane] = static_cast<float>(task.frame().x(pixels[lane])) + 0.5f;
  F x;
  load(column, x);
  for (std::uint32_t i = 0; i < scene.sensor.more_camera_count; ++i)
    depth = select(x > F(static_cast<float>(i + 1) * scene.sensor.column_width), seen_by(scene.sensor.more_cameras[i]),
                   depth);
  return depth;
}

template <class L>
SHEAF_INLINE void put_uv(const SceneView& scene, const Wave& wave, const Slot* slots, const RayState<L>& ray,
                         int channel, const SampleLanes<L>& out) {
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, hit.shape);
  const auto y = surface_point<L, true>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                        hit.instance);
  out.put_words(channel, {y.uv.x, y.uv.y});
}

/// Writes all layers except the albedo, for any BSDF. Returns the lanes and samples for the albedo.
template <class L>
[[gnu::noinline]] SampleLanes<L> aov_tile(const StageContext& context, Wave& wave, const Slot* slots, int column,
                                          int count) {
  using F = Float<L>;
  const SceneView& scene = context.scene;
  CameraTask& task = *context.camera;
  const AovChannels& channels = task.aovs();
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const RadianceState<L> radiance = wave.radiance.gather<L>(slots);
  SampleLanes<L> out = first_surfaces<L>(task.samples, radiance, ray.flags, count);
  if (out.lanes == 0) return out;
  const VertexItem<L> item = wave.vertices.load<L>(column);
  const Vec3<L> ng = select<L>(dot(item.ng, ray.direction) > F(0.0f), -item.ng, item.ng);
  out.put(channels.normal, select<L>(dot(item.ns, ng) < F(0.0f), -item.ns, item.ns));
  out.put(channels.geometric_normal, ng);
  out.put(channels.position, item.p);
  if (channels.depth >= 0) {
    const Uint<L> pixel = wave.paths.gather<L>(slots).pixel;
    out.put_words(channels.depth, {depth_of<L>(scene, task, pixel, item.p)});
  }
  if (channels.uv >= 0) put_uv<L>(scene, wave, slots, ray, channels.uv, out);
  if (channels.surfaces)
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
  out.put(context.camera->aovs().albedo, Vec3<L>{unit(rgb.x), unit(rgb.y), unit(rgb.z)});
}

}  // namespace

template <class L> void aovs(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, Stage::kAovs);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!kIsPhaseFunction<Bsdf<L>>) {
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, L::width);
      for_tiles<L>(run.count, [&](int i, int count) {
        const Slot* slots = wave.sorted.data() + run.slot_begin + i;
        const int column = run.column_begin + i;
        const SampleLanes<L> out = aov_tile<L>(context, wave, slots, column, count);
        if (out.lanes == 0 || context.camera->aovs().albedo < 0) return;
        const Vec3<L> wo = wave.vertices.load<L>(column).wo;
        put_albedo<L>(context, wave, slots, out,
                      directional_albedo<L>(load_bsdf<L, Bsdf>(context.scene, wave, column), wo));
      });
    }
  });
}

SHEAF_INSTANTIATE_STAGE(aovs);

}  // namespace sheaf

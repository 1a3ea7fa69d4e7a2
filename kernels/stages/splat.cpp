// Stage: splat. Converts the unoccluded camera connections of photons' vertices to splats of the task.
#include "core/color/color.h"
#include "kernels/bsdf/list.h"
#include "kernels/photons/light_task.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <cmath>

namespace sheaf {

namespace {

/// Converts the radiance of a path to linear Rec.709. Returns false if a lane is negative or the color is not finite.
bool spectrum_to_rgb(const SceneView& scene, const Wave& wave, Slot slot, const Spectrum4& radiance, float (&rgb)[3]) {
  const float lowest = std::min(std::min(radiance.c0, radiance.c1), std::min(radiance.c2, radiance.c3));
  Vec3f color{radiance.c0, radiance.c1, radiance.c2};
  if (scene.color == ColorMode::kSpectral) {
    const Wavelengths<Scalar> wavelengths = sample_wavelengths<Scalar>(std::fabs(wave.wavelength_samples[slot]));
    color = radiance_to_rgb<Scalar>(*scene.spectral.sensor, wavelengths, radiance);
  }
  rgb[0] = color.x, rgb[1] = color.y, rgb[2] = color.z;
  return lowest >= 0.0f && std::isfinite(color.x + color.y + color.z);
}

void splat_path(const StageContext& context, Wave& wave, Slot slot, int column) {
  Spectrum4& radiance = wave.radiance.row(slot).radiance;
  if (radiance.c0 == 0.0f && radiance.c1 == 0.0f && radiance.c2 == 0.0f && radiance.c3 == 0.0f) return;
  const RasterPosition<Scalar> position = wave.raster_positions.load<Scalar>(column);
  const PathState<Scalar> path = wave.paths.get(slot);
  Splat splat{position.x, position.y, {}, std::uint64_t{wave.radiance.row(slot).task_sample} << 16 | path.dimension()};
  const bool good = spectrum_to_rgb(context.scene, wave, slot, radiance, splat.rgb);
  radiance = Spectrum4(0.0f);
  if (good) {
    context.light_task().splats.push_back(splat);
    return;
  }
  ++wave.stats.dropped.samples;
  if (!wave.first_dropped.any) wave.first_dropped = {true, path.pixel, path.sample};
}

}  // namespace

template <class L> void splat(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("splat"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular) {
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, 1);
      for (int i = 0; i < run.count; ++i)
        splat_path(context, wave, wave.sorted[run.slot_begin + i], run.column_begin + i);
    }
  });
}

SHEAF_INSTANTIATE_STAGE(splat);

}  // namespace sheaf

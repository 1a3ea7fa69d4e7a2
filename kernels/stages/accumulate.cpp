// Stage: accumulate. Moves the radiance of finished paths to the samples of the task. At the end of the task the film
// adds them in order (kernels/render/task_runner.cpp).
//
// In spectral mode the sensor converts the four radiances of a path into linear Rec.709. The color of a single sample
// is usually out of gamut, and its negative components must be kept. So samples are dropped for negative radiances,
// never for negative colors. Pixels of spectral images may have negative components, by noise and for colors outside
// of Rec.709.
#include "core/color/color.h"
#include "core/soa/lane_array.h"
#include "kernels/film/camera_task.h"
#include "kernels/film/film_layout.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Assigns each wavelength to its spectral bin, for films that have bins.
template <class L> void bin_tile(CameraTask& task, int count, const RadianceState<L>& r, const Wavelengths<L>& w) {
  const LaneRows<L, Spectrum> lambdas(w.lambda), pdfs(w.pdf), radiances(r.radiance);
  const LaneArray<Float<L>> weight(r.weight);
  const LaneArray<Uint<L>> index(r.task_sample & Uint<L>(~kTransparent));
  const float per_nm = static_cast<float>(task.spectral_bins()) / (kWavelengthMax - kWavelengthMin);
  for (int lane = 0; lane < count; ++lane) {
    SpectralSample& out = task.samples.spectrum(index[lane]);
    const Spectrum4 lambda = lambdas[lane], pdf = pdfs[lane], radiance = radiances[lane];
    const auto add = [&](int k, float at, float value) {
      const int bin = static_cast<int>((at - kWavelengthMin) * per_nm);
      out.bin[k] = static_cast<std::uint16_t>(std::min(bin, task.spectral_bins() - 1));
      out.value[k] = value;
    };
    add(0, lambda.c0, 0.25f * weight[lane] * radiance.c0 / pdf.c0);
    add(1, lambda.c1, 0.25f * weight[lane] * radiance.c1 / pdf.c1);
    add(2, lambda.c2, 0.25f * weight[lane] * radiance.c2 / pdf.c2);
    add(3, lambda.c3, 0.25f * weight[lane] * radiance.c3 / pdf.c3);
  }
}

/// Converts the radiances of `slots` to linear Rec.709 in place. The fourth lane becomes -1 if a radiance is negative,
/// otherwise 0.
template <class L>
SHEAF_INLINE void spectrum_to_rgb(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  RadianceState<L> r = wave.radiance.gather<L>(slots);
  const F lowest = min(min(r.radiance.c0, r.radiance.c1), min(r.radiance.c2, r.radiance.c3));
  const Wavelengths<L> wavelengths = sample_wavelengths<L>(abs(gather_wavelength_samples<L>(wave, slots)));
  if (context.camera_task().samples.has_spectra()) bin_tile<L>(context.camera_task(), count, r, wavelengths);
  const Vec3<L> rgb = radiance_to_rgb<L>(*context.scene.spectral.sensor, wavelengths, r.radiance);
  r.radiance = {rgb.x, rgb.y, rgb.z, select(lowest >= F(0.0f), F(0.0f), F(-1.0f))};
  wave.radiance.scatter<L>(slots, count, r);
}

/// Whether a sample may be added to the film. `r`: in spectral mode after spectrum_to_rgb().
bool is_good(ColorMode color, const RadianceState<Scalar>& r) {
  const Spectrum4& c = r.radiance;
  if (!std::isfinite((c.c0 + c.c1 + c.c2) * r.weight)) return false;
  return color == ColorMode::kSpectral ? c.c3 >= 0.0f : c.c0 >= 0.0f && c.c1 >= 0.0f && c.c2 >= 0.0f;
}

}  // namespace

template <class L> void accumulate(const StageContext& context, Wave& wave) noexcept {
  const int paths = wave.finished.size();
  if (paths == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("accumulate"));
  timer.count(paths, 1);
  if (context.scene.color == ColorMode::kSpectral && context.transports_light()) {
    wave.finished.pad();
    for_tiles<L>(paths, [&](int i, int count) { spectrum_to_rgb<L>(context, wave, wave.finished.data() + i, count); });
  }
  SampleBuffer& samples = context.camera_task().samples;
  for (int i = 0; i < paths; ++i) {
    const Slot slot = wave.finished[i];
    const RadianceState<Scalar> r = wave.radiance.get(slot);
    const std::size_t sample = r.task_sample & ~kTransparent;
    if (is_good(context.scene.color, r)) {
      float* out = samples[sample];
      out[kRed] = r.radiance.c0 * r.weight;
      out[kGreen] = r.radiance.c1 * r.weight;
      out[kBlue] = r.radiance.c2 * r.weight;
      out[kAlpha] = r.task_sample & kTransparent ? 0.0f : r.weight;
      ++wave.stats.samples;
    } else {
      samples.drop(sample);
      ++wave.stats.dropped.samples;
      const PathState<Scalar> path = wave.paths.get(slot);
      if (!wave.first_dropped.any) wave.first_dropped = {true, path.pixel, path.sample};
    }
    wave.free.push(slot);
  }
  wave.finished.clear();
}

SHEAF_INSTANTIATE_STAGE(accumulate);

}  // namespace sheaf

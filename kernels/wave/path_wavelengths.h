// The wavelengths of paths in spectral mode.
//
// Each path stores the one number from which its four wavelengths are derived. A dispersive surface reduces a path to a
// single wavelength and sets the sign bit of that number. From then on all four lanes hold the first wavelength, and
// the throughput of the other three lanes is and stays 0. BSDFs choose what they sample by the brightest lane; with
// equal wavelengths, the dead lanes cannot affect that choice.
#pragma once

#include "core/color/wavelengths.h"
#include "core/soa/lane_array.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Bit of a word of Wave::wavelength_samples: the path has a single wavelength.
inline constexpr std::uint32_t kSingleWavelength = 0x80000000u;

/// Gathers words of Wave::wavelength_samples.
template <class L> SHEAF_INLINE Float<L> gather_wavelength_samples(const Wave& wave, const Slot* slots) {
  return make_lanes<Float<L>>([&](int lane) SHEAF_LAMBDA_INLINE { return wave.wavelength_samples[slots[lane]]; });
}

/// Stores the first `count` lanes of `u` to words of Wave::wavelength_samples.
template <class L> SHEAF_INLINE void scatter_wavelength_samples(Wave& wave, const Slot* slots, int count, Float<L> u) {
  const LaneArray<Float<L>> words(u);
  for (int lane = 0; lane < count; ++lane) wave.wavelength_samples[slots[lane]] = words[lane];
}

/// Whether the path has a single wavelength.
inline bool has_single_wavelength(const StageContext& context, const Wave& wave, Slot slot) {
  return context.scene.color == ColorMode::kSpectral &&
         (float_bits(wave.wavelength_samples[slot]) & kSingleWavelength) != 0;
}

/// Current wavelengths of the paths, nm in [360, 830].
template <class L> SHEAF_INLINE Spectrum<L> path_wavelengths(const Wave& wave, const Slot* slots) {
  using U = Uint<L>;
  const Float<L> hero = gather_wavelength_samples<L>(wave, slots);
  Spectrum<L> lambda = sample_wavelengths<L>(abs(hero)).lambda;
  const auto single = (float_bits(hero) & U(kSingleWavelength)) != U(0u);
  if (any(single)) lambda = select<L>(single, Spectrum<L>(lambda.c0), lambda);
  return lambda;
}

/// path_wavelengths() in spectral mode; empty in RGB mode.
template <class L, ColorMode kMode> SHEAF_INLINE Spectrum<L> shading_wavelengths(const Wave& wave, const Slot* slots) {
  if constexpr (kMode == ColorMode::kSpectral) return path_wavelengths<L>(wave, slots);
  return {};
}

/// Calls f.operator()<ColorMode>() for the scene's mode, so that a stage branches on it only once.
template <class F> SHEAF_INLINE void with_color_mode(const SceneView& scene, F&& f) {
  if (scene.color == ColorMode::kSpectral) {
    f.template operator()<ColorMode::kSpectral>();
  } else {
    f.template operator()<ColorMode::kRgb>();
  }
}

}  // namespace sheaf

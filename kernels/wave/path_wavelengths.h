// The wavelengths of paths in spectral mode.
//
// Each path keeps the one number that its four wavelengths are made of. Where a path becomes one of a single wavelength
// (refraction by a dispersing surface), the sign of that number is set: from then on all four lanes are at the first
// wavelength, and the throughput of the others is 0 and stays so. Lanes that are all alike leave to BSDFs, which weigh
// what they sample by the brightest lane, no reason to look at what is no longer there.
#pragma once

#include "core/wavelengths.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Bit of a word of Wave::wavelength_samples: one wavelength is left.
inline constexpr std::uint32_t kSingleWavelength = 0x80000000u;

/// Words of Wave::wavelength_samples.
template <class L> SHEAF_INLINE Float<L> gather_wavelength_samples(const Wave& wave, const Slot* slots) {
  alignas(kSimdAlignment) float words[L::width];
  for (int lane = 0; lane < L::width; ++lane) words[lane] = wave.wavelength_samples[slots[lane]];
  Float<L> out;
  load(words, out);
  return out;
}

/// Whether one wavelength of the path is left.
inline bool has_single_wavelength(const StageContext& context, const Wave& wave, Slot slot) {
  return context.scene.color == ColorMode::kSpectral &&
         (float_bits(wave.wavelength_samples[slot]) & kSingleWavelength) != 0;
}

/// The wavelengths, nm in [360, 830], at which the paths are to be shaded now.
template <class L> SHEAF_INLINE Spectrum<L> path_wavelengths(const Wave& wave, const Slot* slots) {
  using U = Uint<L>;
  const Float<L> hero = gather_wavelength_samples<L>(wave, slots);
  Spectrum<L> lambda = sample_wavelengths<L>(abs(hero)).lambda;
  const auto single = (float_bits(hero) & U(kSingleWavelength)) != U(0u);
  if (any(single)) lambda = select<L>(single, Spectrum<L>(lambda.c0), lambda);
  return lambda;
}

/// path_wavelengths() in spectral mode; in RGB mode nothing.
template <class L, ColorMode Mode> SHEAF_INLINE Spectrum<L> shading_wavelengths(const Wave& wave, const Slot* slots) {
  if constexpr (Mode == ColorMode::kSpectral) return path_wavelengths<L>(wave, slots);
  return {};
}

/// Calls f.operator()<ColorMode>() for the scene's mode: the one branch of a stage on it.
template <class F> SHEAF_INLINE void with_color_mode(const SceneView& scene, F&& f) {
  if (scene.color == ColorMode::kSpectral) {
    f.template operator()<ColorMode::kSpectral>();
  } else {
    f.template operator()<ColorMode::kRgb>();
  }
}

}  // namespace sheaf

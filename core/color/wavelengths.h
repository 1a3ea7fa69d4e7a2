// Hero wavelength sampling (Wilkie et al. 2014): the four wavelengths of a path in spectral mode, from one uniform
// number.
#pragma once

#include "core/color/spectrum.h"
#include "core/soa/lane_array.h"

namespace sheaf {

/// Four wavelengths and the pdf of each. All four have the same pdf as a function of wavelength.
template <class L> struct Wavelengths {
  Spectrum<L> lambda;  ///< nm, in [360, 830]
  Spectrum<L> pdf;     ///< per nm; positive
  static constexpr auto fields(auto& s) { return std::tie(s.lambda, s.pdf); }
};

/// The pdf of wavelengths, constant between its quantiles.
///
/// With one wavelength per path, a pdf like the length of the sensor's response would minimize the noise of white. Four
/// wavelengths are a quarter of the probability apart. Their mean cancels all harmonics of response over pdf except
/// those of order 4, 8, ... This pdf is optimized to make the remaining harmonics small for three lights.
/// bench/README.md compares.
struct WavelengthQuantiles {
  static constexpr int kCellBits = 6, kCells = 1 << kCellBits;  ///< per quarter
  /// Row i: the quantiles, in nm, of (i / kCells + k) / 4 for k = 0 ... 3.
  alignas(16) float nodes[kCells + 1][4];

  WavelengthQuantiles();
};
extern const WavelengthQuantiles kWavelengthQuantiles;

namespace detail {
/// Rotates the lanes `by` positions, in [0, 3], towards the front.
template <class L> SHEAF_INLINE Spectrum<L> rotate_lanes(const Spectrum<L>& s, typename L::Uint by) {
  using U = typename L::Uint;
  const auto odd = (by & U(1u)) != U(0u), high = (by & U(2u)) != U(0u);
  const Spectrum<L> once = select<L>(odd, Spectrum<L>(s.c1, s.c2, s.c3, s.c0), s);
  return select<L>(high, Spectrum<L>(once.c2, once.c3, once.c0, once.c1), once);
}
}  // namespace detail

/// Samples the wavelengths with `u` in [0, 1). The first inverts the CDF at u, the others at u + k/4 modulo 1. Each by
/// itself has the pdf; together they cover the whole range (Wilkie et al., "Hero Wavelength Spectral Sampling", EGSR
/// 2014, but with the rotation before the inversion). A path stores only u and calls this wherever it needs the
/// wavelengths.
template <class L> SHEAF_INLINE Wavelengths<L> sample_wavelengths(typename L::Float u) {
  using F = typename L::Float;
  using U = typename L::Uint;
  constexpr std::uint32_t kCells = WavelengthQuantiles::kCells;
  const F position = u * F(float(4 * kCells));
  const U cell = min(to_uint(position), U(4 * kCells - 1));
  const F t = position - to_float(cell);
  const U row = cell & U(kCells - 1), rotation = cell >> WavelengthQuantiles::kCellBits;
  F below[4], above[4];
  RowPointers<L> nodes(kWavelengthQuantiles.nodes, row);
  nodes.read_four(below);
  nodes.read_four(above);
  F lambda[4], pdf[4];
  for (int k = 0; k < 4; ++k) {
    const F width = above[k] - below[k];
    lambda[k] = fma(t, width, below[k]);
    pdf[k] = F(1.0f / float(4 * kCells)) / width;
  }
  return {detail::rotate_lanes<L>({lambda[0], lambda[1], lambda[2], lambda[3]}, rotation),
          detail::rotate_lanes<L>({pdf[0], pdf[1], pdf[2], pdf[3]}, rotation)};
}

}  // namespace sheaf

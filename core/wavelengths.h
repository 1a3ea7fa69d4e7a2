// Hero wavelengths: the four wavelengths that a path carries in spectral mode, all made from one uniform number.
#pragma once

#include "core/spectrum.h"

namespace sheaf {

/// Four wavelengths and the density of each, which is the same function of wavelength for all four.
template <class L> struct Wavelengths {
  Spectrum<L> lambda;  ///< nm, in [360, 830]
  Spectrum<L> pdf;     ///< per nm; positive
  static constexpr auto fields(auto& s) { return std::tie(s.lambda, s.pdf); }
};

/// The density of wavelengths, constant between its quantiles.
///
/// For one wavelength per path, a density like the length of the sensor's response would leave the least noise in
/// white. Of four, a quarter apart in probability, the mean takes away all but the harmonics of order 4, 8, ... of
/// response over density; this one was found by making these small in three lights. bench/README.md compares.
struct WavelengthQuantiles {
  static constexpr int kCellBits = 6, kCells = 1 << kCellBits;  ///< per quarter
  /// Row i: the quantiles, nm, of (i / kCells + k) / 4 for k = 0 ... 3.
  alignas(16) float nodes[kCells + 1][4];

  WavelengthQuantiles();
};
extern const WavelengthQuantiles kWavelengthQuantiles;

namespace detail {
/// Moves the lanes `by` places towards the front, round the end; by in [0, 3].
template <class L> SHEAF_INLINE Spectrum<L> rotate_lanes(const Spectrum<L>& s, typename L::Uint by) {
  using U = typename L::Uint;
  const auto odd = (by & U(1u)) != U(0u), high = (by & U(2u)) != U(0u);
  const Spectrum<L> once = select<L>(odd, Spectrum<L>(s.c1, s.c2, s.c3, s.c0), s);
  return select<L>(high, Spectrum<L>(once.c2, once.c3, once.c0, once.c1), once);
}
}  // namespace detail

/// The wavelengths that belong to `u` in [0, 1). The first inverts the density's cumulative function at u, the others
/// at u + k/4 modulo 1: each alone has the density, together they are spread over the whole range (Wilkie et al.,
/// "Hero Wavelength Spectral Sampling", EGSR 2014, with the rotation before the inversion instead of after it). A
/// path stores u alone and calls this wherever it needs the wavelengths.
template <class L> SHEAF_INLINE Wavelengths<L> sample_wavelengths(typename L::Float u) {
  using F = typename L::Float;
  using U = typename L::Uint;
  constexpr std::uint32_t kCells = WavelengthQuantiles::kCells;
  const F place = u * F(float(4 * kCells));
  const U cell = min(to_uint(place), U(4 * kCells - 1));
  const F t = place - to_float(cell);
  const U row = cell & U(kCells - 1), turn = cell >> WavelengthQuantiles::kCellBits;
  alignas(kSimdAlignment) std::uint32_t at[L::width];
  store(at, row);
  const float *rows[L::width], *next_rows[L::width];
  for (int lane = 0; lane < L::width; ++lane)
    rows[lane] = kWavelengthQuantiles.nodes[at[lane]], next_rows[lane] = rows[lane] + 4;
  F below[4], above[4];
  load_rows4(rows, below);
  load_rows4(next_rows, above);
  F lambda[4], pdf[4];
  for (int k = 0; k < 4; ++k) {
    const F width = above[k] - below[k];
    lambda[k] = fma(t, width, below[k]);
    pdf[k] = F(1.0f / float(4 * kCells)) / width;
  }
  return {detail::rotate_lanes<L>({lambda[0], lambda[1], lambda[2], lambda[3]}, turn),
          detail::rotate_lanes<L>({pdf[0], pdf[1], pdf[2], pdf[3]}, turn)};
}

/// What a path's throughput is to be multiplied by when light is found: the balance heuristic over the four wavelengths
/// as strategies (Wilkie et al. 2014). `relative` holds, for each wavelength, the density with which it would have made
/// the path, over the density by which the throughput was divided (that of the first). One everywhere gives 1; where
/// only the first could have made the path (refraction by a dispersing surface: 1, 0, 0, 0) it gives 4.
template <class L> SHEAF_INLINE Float<L> hero_balance(Spectrum<L> relative) {
  return Float<L>(4.0f) / ((relative.c0 + relative.c1) + (relative.c2 + relative.c3));
}

}  // namespace sheaf

// Spectra in tables for kernels: one row of 32 bytes, evaluated at the four wavelengths of every path without branches
// on the kind of spectrum.
#pragma once

#include "core/color/sigmoid_polynomial.h"
#include "core/soa/lane_array.h"
#include "core/soa/record_table.h"

namespace sheaf {

/// The spectrum scale * sigmoid polynomial * table, in which each factor may be 1 everywhere. Constants and tabulated
/// spectra have an infinite c2, whose sigmoid is exactly 1. An emitter given as a color has a polynomial and the table
/// of D65.
struct alignas(32) SpectrumRow {
  float c0 = 0, c1 = 0, c2 = kInfinity;  ///< see SigmoidPolynomial
  float scale = 0;
  std::uint32_t table = 0;  ///< index of the table; 0: none
  std::uint32_t padding[3] = {};

  /// Whether the spectrum is constant.
  bool is_flat() const { return c0 == 0 && c1 == 0 && table == 0; }
  bool operator==(const SpectrumRow&) const = default;
};

/// The tables of SpectrumRow: samples every nanometer from 360 to 830 nm, linear in between.
struct SpectrumTableView {
  static constexpr int kSamples = 471;
  /// Floats from one table to the next.
  static constexpr std::uint32_t kStride = 472;
  /// Table 0 is 1 everywhere. Table 1 is the spectrum of D65 with Y = 1, for emitted colors such as texels of
  /// environment maps.
  static constexpr std::uint32_t kNone = 0, kDaylight = 1;
  const float* samples = nullptr;
};

/// The value of table `table` at `lambda` nm, in [360, 830].
template <class L>
SHEAF_INLINE Float<L> evaluate_table(SpectrumTableView view, typename L::Uint table, typename L::Float lambda) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const F position = clamp(lambda - F(360.0f), F(0.0f), F(float(SpectrumTableView::kSamples - 1)));
  const U i = min(to_uint(position), U(std::uint32_t(SpectrumTableView::kSamples - 2)));
  const F t = position - to_float(i);
  const U at = table * U(SpectrumTableView::kStride) + i;
  return lerp(t, gather(view.samples, at), gather(view.samples, at + U(1u)));
}

template <class L>
SHEAF_INLINE Spectrum<L> evaluate_table(SpectrumTableView view, typename L::Uint table, const Spectrum<L>& lambda) {
  return {evaluate_table<L>(view, table, lambda.c0), evaluate_table<L>(view, table, lambda.c1),
          evaluate_table<L>(view, table, lambda.c2), evaluate_table<L>(view, table, lambda.c3)};
}

/// One row per lane, in registers.
template <class L> struct LoadedSpectrum {
  SigmoidPolynomial<L> shape;
  typename L::Float scale{};
  typename L::Uint table{};
  static constexpr auto fields(auto& s) { return std::tie(s.shape, s.scale, s.table); }
};

/// Reads one row per lane.
template <class L> SHEAF_INLINE LoadedSpectrum<L> load_spectrum(const SpectrumRow* rows, typename L::Uint index) {
  typename L::Float c[4];
  RowPointers<L>(rows, index).read_four(c);
  return {{c[0], c[1], c[2]}, c[3], gather_member<L>(rows, &SpectrumRow::table, index)};
}

/// The spectrum at the wavelengths of each lane, in nm within [360, 830].
template <class L>
SHEAF_INLINE Spectrum<L> evaluate(const LoadedSpectrum<L>& row, SpectrumTableView tables, const Spectrum<L>& lambda) {
  using U = typename L::Uint;
  Spectrum<L> value = evaluate(row.shape, lambda) * row.scale;
  if (any(row.table != U(0u))) value = value * evaluate_table<L>(tables, row.table, lambda);
  return value;
}

template <class L>
SHEAF_INLINE Spectrum<L> evaluate(const SpectrumRow* rows, typename L::Uint index, SpectrumTableView tables,
                                  const Spectrum<L>& lambda) {
  return evaluate(load_spectrum<L>(rows, index), tables, lambda);
}

}  // namespace sheaf

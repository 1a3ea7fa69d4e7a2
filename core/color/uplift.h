// Spectral upsampling: from a Rec.709 color to a smooth spectrum that has this color under D65. Single colors are
// fitted; texels of images use a table.
//
// The spectra are those of Jakob and Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling"
// (Eurographics 2019). Two things differ. The fit is Newton's method on linear Rec.709, which is so fast in wide
// registers that the table is computed at first use and never stored. Colors darker than kUpliftDarkest are scaled
// spectra of that brightness, because a sigmoid has no advantage over a factor there.
#pragma once

#include "core/color/sigmoid_polynomial.h"
#include "core/simd/simd_rows.h"
#include "core/soa/lane_array.h"

#include <vector>

namespace sheaf {

/// scale * shape(lambda).
template <class L> struct ScaledSigmoid {
  SigmoidPolynomial<L> shape;
  typename L::Float scale{};
  static constexpr auto fields(auto& s) { return std::tie(s.shape, s.scale); }
};

template <class L> SHEAF_INLINE Spectrum<L> evaluate(const ScaledSigmoid<L>& s, const Spectrum<L>& lambda) {
  return evaluate(s.shape, lambda) * s.scale;
}

/// Reflectances whose maximum component is smaller are scaled spectra of this brightness.
inline constexpr float kUpliftDarkest = 0.25f;
/// Maximum component of the reflectance that represents unbounded colors.
inline constexpr float kUpliftUnbounded = 0.5f;

/// Coefficients over the cube of colors.
///
/// There is one grid for each choice of the largest component, whose value `z` is one axis. The other two axes are the
/// ratios of the next two components (in the order R, G, B, R, ...) to it. Nodes are dense where the coefficients
/// change fast: towards z = 1 and towards ratios of 0 and 1.
struct UpliftTable {
  static constexpr int kSize = 32;  ///< nodes per axis
  /// c0, c1, c2 and one word of padding per node, at ((largest * kSize + z) * kSize + second) * kSize + first.
  std::vector<float> nodes;

  UpliftTable();
  /// Computed by the first call, in parallel. The last digits depend on the instruction set, but not on threads.
  static const UpliftTable& get();

  /// Position on its axis, from 0 to kSize - 1, of a ratio or of a brightness in [kUpliftDarkest, 1]; and the inverse.
  template <class F> static F ratio_position(F ratio) {
    return (sqrt(ratio) + (F(1.0f) - safe_sqrt(F(1.0f) - ratio))) * F(0.5f * float(kSize - 1));
  }
  static float ratio_at(float position);
  template <class F> static F brightness_position(F z) {
    return (F(1.0f) - safe_sqrt((F(1.0f) - z) * F(1.0f / (1.0f - kUpliftDarkest)))) * F(float(kSize - 1));
  }
  static float brightness_at(float position) {
    return 1.0f - sqr(1.0f - position / float(kSize - 1)) * (1.0f - kUpliftDarkest);
  }
};

/// Fits the spectrum of a reflectance or transmittance to within 1e-4 per component. Components are clamped to [0, 1];
/// grays are exactly constant. Takes about 10 microseconds.
ScaledSigmoid<Scalar> fit_reflectance(Vec3f rgb);

/// The same for a quantity without upper limit. Negative components count as 0.
ScaledSigmoid<Scalar> fit_unbounded(Vec3f rgb);

namespace detail {

/// Bilinear in the ratios, linear in brightness. All arguments lie within the table.
template <class L>
SHEAF_INLINE SigmoidPolynomial<L> interpolate(const UpliftTable& table, typename L::Uint largest, Vec3<L> position) {
  using F = typename L::Float;
  using U = typename L::Uint;
  constexpr int kSize = UpliftTable::kSize;
  // Find the cell and the position within it
  const auto cell = [](F p) { return min(to_uint(p), U(std::uint32_t(kSize - 2))); };
  const U x = cell(position.x), y = cell(position.y), z = cell(position.z);
  const F fx = position.x - to_float(x), fy = position.y - to_float(y), fz = position.z - to_float(z);
  const U size = U(std::uint32_t(kSize));
  const U first = (((largest * size + z) * size + y) * size + x) << 2;
  const LaneArray<U> offset(first);
  const auto corner = [&](std::uint32_t by, F(&c)[4]) {
    const float* rows[L::width];
    for (int lane = 0; lane < L::width; ++lane) rows[lane] = table.nodes.data() + offset[lane] + 4 * by;
    load_rows4(rows, c);
  };
  // Sum the weighted corners
  F sum[3] = {F(0.0f), F(0.0f), F(0.0f)};
  for (std::uint32_t k = 0; k < 8; ++k) {
    const bool bx = (k & 1u) != 0, by = (k & 2u) != 0, bz = (k & 4u) != 0;
    const F weight = (bx ? fx : F(1.0f) - fx) * (by ? fy : F(1.0f) - fy) * (bz ? fz : F(1.0f) - fz);
    F c[4];
    corner((bx ? 1u : 0u) + (by ? std::uint32_t(kSize) : 0u) + (bz ? std::uint32_t(kSize * kSize) : 0u), c);
    for (int j = 0; j < 3; ++j) sum[j] = fma(weight, c[j], sum[j]);
  }
  return {sum[0], sum[1], sum[2]};
}

/// The shape of the spectrum of a color with maximum component `largest`, at brightness `z` in [kUpliftDarkest, 1].
template <class L>
SHEAF_INLINE SigmoidPolynomial<L> look_up(const UpliftTable& table, Vec3<L> rgb, typename L::Float largest,
                                          typename L::Float z) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto red = (rgb.x >= rgb.y) & (rgb.x >= rgb.z);
  const auto green = (!red) & (rgb.y >= rgb.z);
  const U axis = select(red, U(0u), select(green, U(1u), U(2u)));
  const F per = F(1.0f) / max(largest, F(1e-30f));
  const F first = select(red, rgb.y, select(green, rgb.z, rgb.x));
  const F second = select(red, rgb.z, select(green, rgb.x, rgb.y));
  const auto ratio = [&](F c) { return UpliftTable::ratio_position(clamp(c * per, F(0.0f), F(1.0f))); };
  return interpolate<L>(table, axis, {ratio(first), ratio(second), UpliftTable::brightness_position(z)});
}

/// In gray lanes, the constant sigmoid(c2).
template <class L>
SHEAF_INLINE SigmoidPolynomial<L> flat_where(Mask<L> gray, float c2, const SigmoidPolynomial<L>& other) {
  using F = typename L::Float;
  return {select(gray, F(0.0f), other.c0), select(gray, F(0.0f), other.c1), select(gray, F(c2), other.c2)};
}

}  // namespace detail

/// The spectrum of a reflectance from the table; components are clamped to [0, 1]. Grays are exactly constant. Other
/// colors have an error below 0.005 per component.
template <class L> SHEAF_INLINE ScaledSigmoid<L> uplift_reflectance(const UpliftTable& table, Vec3<L> rgb) {
  using F = typename L::Float;
  const auto bounded = [](F c) { return clamp(c, F(0.0f), F(1.0f)); };
  rgb = {bounded(rgb.x), bounded(rgb.y), bounded(rgb.z)};
  const F largest = max_component(rgb);
  const F z = max(largest, F(kUpliftDarkest));
  const auto gray = min(rgb.x, min(rgb.y, rgb.z)) == largest;
  return {detail::flat_where<L>(gray, kInfinity, detail::look_up<L>(table, rgb, largest, z)),
          select(gray, largest, largest / z)};
}

/// The same for quantities without upper limit, such as the nodes of an environment map (to be multiplied by D65). The
/// shape is that of the color with maximum component kUpliftUnbounded. For grays, including black, it is exactly
/// kUpliftUnbounded everywhere.
template <class L> SHEAF_INLINE ScaledSigmoid<L> uplift_unbounded(const UpliftTable& table, Vec3<L> rgb) {
  using F = typename L::Float;
  rgb = {max(rgb.x, F(0.0f)), max(rgb.y, F(0.0f)), max(rgb.z, F(0.0f))};
  const F largest = max_component(rgb);
  const auto gray = min(rgb.x, min(rgb.y, rgb.z)) == largest;
  static_assert(kUpliftUnbounded == 0.5f);  // sigmoid(0)
  return {detail::flat_where<L>(gray, 0.0f, detail::look_up<L>(table, rgb, largest, F(kUpliftUnbounded))),
          largest * F(1.0f / kUpliftUnbounded)};
}

}  // namespace sheaf

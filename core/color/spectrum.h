// Four spectral lanes: (R, G, B, 0) in RGB mode, four hero wavelengths in spectral mode.
#pragma once

#include "core/math/vec.h"

namespace sheaf {

/// The meaning of the four lanes of a Spectrum.
enum class ColorMode : std::uint32_t {
  kRgb,       ///< linear Rec.709 in three lanes
  kSpectral,  ///< four wavelengths, different for each path
};

/// Radiance, throughput, reflectance etc. in four spectral lanes.
template <class L> struct Spectrum {
  typename L::Float c0{}, c1{}, c2{}, c3{};
  static constexpr auto fields(auto& s) { return std::tie(s.c0, s.c1, s.c2, s.c3); }

  Spectrum() = default;
  SHEAF_INLINE Spectrum(typename L::Float a, typename L::Float b, typename L::Float c, typename L::Float d)
      : c0(a), c1(b), c2(c), c3(d) {}
  /// The same value in all four lanes.
  SHEAF_INLINE explicit Spectrum(typename L::Float v) : c0(v), c1(v), c2(v), c3(v) {}
};

using Spectrum4 = Spectrum<Scalar>;

template <class L> SHEAF_INLINE Spectrum<L> operator+(Spectrum<L> a, Spectrum<L> b) {
  return {a.c0 + b.c0, a.c1 + b.c1, a.c2 + b.c2, a.c3 + b.c3};
}
template <class L> SHEAF_INLINE Spectrum<L> operator*(Spectrum<L> a, Spectrum<L> b) {
  return {a.c0 * b.c0, a.c1 * b.c1, a.c2 * b.c2, a.c3 * b.c3};
}
template <class L> SHEAF_INLINE Spectrum<L> operator*(Spectrum<L> a, typename L::Float s) {
  return {a.c0 * s, a.c1 * s, a.c2 * s, a.c3 * s};
}
template <class L> SHEAF_INLINE Float<L> max_component(Spectrum<L> a) { return max(max(a.c0, a.c1), max(a.c2, a.c3)); }
template <class L> SHEAF_INLINE Spectrum<L> select(Mask<L> m, Spectrum<L> a, Spectrum<L> b) {
  return {select(m, a.c0, b.c0), select(m, a.c1, b.c1), select(m, a.c2, b.c2), select(m, a.c3, b.c3)};
}
/// f of each of the four lanes.
template <class L, class F> SHEAF_INLINE Spectrum<L> map_spectrum(const Spectrum<L>& a, F&& f) {
  return {f(a.c0), f(a.c1), f(a.c2), f(a.c3)};
}
/// The sum of all four lanes.
template <class L> SHEAF_INLINE Float<L> total(Spectrum<L> a) { return (a.c0 + a.c1) + (a.c2 + a.c3); }
template <class L> SHEAF_INLINE Mask<L> is_black(Spectrum<L> a) { return max_component(a) <= Float<L>(0.0f); }

}  // namespace sheaf

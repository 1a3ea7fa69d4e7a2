// Warps from uniform numbers in [0, 1)^2 to directions and points, with their pdfs.
#pragma once

#include "core/math/vec.h"

namespace sheaf {

template <class L> struct SinCos { typename L::Float sin, cos; };

/// sin and cos of 2 pi u for u in [0, 1], with an absolute error below 4e-7. The angle is folded into [-pi/4, pi/4]
/// exactly, so that short polynomials suffice (minimax coefficients of sinf and cosf in the Cephes library).
template <class L> SHEAF_INLINE SinCos<L> sincos_2pi(typename L::Float u) {
  using F = typename L::Float;
  const F quarter = floor(u * F(4.0f) + F(0.5f));
  const F x = (u * F(4.0f) - quarter) * F(1.57079632679f);
  const F x2 = x * x;
  const F s = x + x * x2 * (F(-1.6666654611e-1f) + x2 * (F(8.3321608736e-3f) + x2 * F(-1.9515295891e-4f)));
  const F c = F(1.0f) - F(0.5f) * x2 +
              x2 * x2 * (F(4.166664568298827e-2f) + x2 * (F(-1.388731625493765e-3f) + x2 * F(2.443315711809948e-5f)));
  const auto q = to_uint(quarter);
  const auto odd = (q & decltype(q)(1u)) != decltype(q)(0u);
  const auto sin_negative = (q & decltype(q)(2u)) != decltype(q)(0u);
  const auto cos_negative = ((q + decltype(q)(1u)) & decltype(q)(2u)) != decltype(q)(0u);
  const F a = select(odd, c, s), b = select(odd, s, c);
  return {select(sin_negative, -a, a), select(cos_negative, -b, b)};
}

/// Concentric map from the square to the unit disk (Shirley and Chiu 1997); preserves areas.
template <class L> SHEAF_INLINE Vec2<L> square_to_disk(typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  const F a = F(2.0f) * u - F(1.0f), b = F(2.0f) * v - F(1.0f);
  const auto a_larger = abs(a) > abs(b);
  const F r = select(a_larger, a, b);
  const F other = select(a_larger, b, a);
  const F ratio = select(r == F(0.0f), F(0.0f), other / select(r == F(0.0f), F(1.0f), r));
  // The angle from the larger axis is ratio * pi/4, which is within the range of the polynomials of sincos_2pi.
  const F x = ratio * F(0.78539816339f), x2 = x * x;
  const F s = x + x * x2 * (F(-1.6666654611e-1f) + x2 * (F(8.3321608736e-3f) + x2 * F(-1.9515295891e-4f)));
  const F c = F(1.0f) - F(0.5f) * x2 +
              x2 * x2 * (F(4.166664568298827e-2f) + x2 * (F(-1.388731625493765e-3f) + x2 * F(2.443315711809948e-5f)));
  return {r * select(a_larger, c, s), r * select(a_larger, s, c)};
}

/// A direction in the upper hemisphere with solid-angle pdf cos(theta) / pi.
template <class L> SHEAF_INLINE Vec3<L> square_to_cosine_hemisphere(typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  const Vec2<L> d = square_to_disk<L>(u, v);
  return {d.x, d.y, safe_sqrt(F(1.0f) - d.x * d.x - d.y * d.y)};
}
template <class F> SHEAF_INLINE F cosine_hemisphere_pdf_solid_angle(F cos_theta) {
  return max(cos_theta, F(0.0f)) * F(kInvPi);
}

/// A direction on the unit sphere with solid-angle pdf 1 / (4 pi).
template <class L> SHEAF_INLINE Vec3<L> square_to_sphere(typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  const F z = F(1.0f) - F(2.0f) * u;
  const F r = safe_sqrt(F(1.0f) - z * z);
  const auto sc = sincos_2pi<L>(v);
  return {r * sc.cos, r * sc.sin, z};
}
inline constexpr float kUniformSpherePdf = 0.25f * kInvPi;

/// A direction in a cone around +z, with solid-angle pdf 1 / (2 pi one_minus_cos_max). `one_minus_cos_max`: 1 - cos of
/// the half angle of the cone. Stays exact for cones of any narrowness.
template <class L>
SHEAF_INLINE Vec3<L> square_to_cone(typename L::Float u, typename L::Float v, typename L::Float one_minus_cos_max) {
  using F = typename L::Float;
  const F one_minus_cos = u * one_minus_cos_max;
  const F sin_theta = safe_sqrt(one_minus_cos * (F(2.0f) - one_minus_cos));
  const auto sc = sincos_2pi<L>(v);
  return {sin_theta * sc.cos, sin_theta * sc.sin, F(1.0f) - one_minus_cos};
}

/// Barycentric coordinates (b1, b2), uniform over a triangle.
template <class L> SHEAF_INLINE Vec2<L> square_to_triangle(typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  const F r = sqrt(u);
  return {F(1.0f) - r, v * r};
}

/// Positive weights at the corners of the unit square: (0, 0), (1, 0), (0, 1), (1, 1).
template <class L> struct CornerWeights { typename L::Float w00, w10, w01, w11; };

/// A point in the unit square whose pdf is proportional to the bilinear interpolation of `w` (Hart et al., "Practical
/// Product Sampling by Fitting and Composing Warps", 2020).
template <class L>
SHEAF_INLINE Vec2<L> square_to_bilinear(const CornerWeights<L>& w, typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  const auto sample_linear = [](F number, F a, F b) SHEAF_LAMBDA_INLINE {
    const F at = number * (a + b) / (a + sqrt(a * a + number * (b * b - a * a)));
    return min(at, F(kOneMinusEpsilon));
  };
  const F y = sample_linear(v, w.w00 + w.w10, w.w01 + w.w11);
  return {sample_linear(u, w.w00 + y * (w.w01 - w.w00), w.w10 + y * (w.w11 - w.w10)), y};
}

/// Pdf of square_to_bilinear() at `p`.
template <class L> SHEAF_INLINE Float<L> bilinear_pdf(const CornerWeights<L>& w, const Vec2<L>& p) {
  using F = Float<L>;
  const F left = w.w00 + p.y * (w.w01 - w.w00), right = w.w10 + p.y * (w.w11 - w.w10);
  return F(4.0f) * (left + p.x * (right - left)) / (w.w00 + w.w10 + w.w01 + w.w11);
}

}  // namespace sheaf

// Lane policies: the template parameter `L` of all mathematics in Sheaf.
//
// Code that is generic in `L` uses L::Float, L::Uint, L::Mask and the functions of core/simd/simd.h. So the same source
// compiles for Scalar (one path; tests, scene compilation) and for Wide (kWidth paths; kernels).
#pragma once

#include "core/simd/simd.h"

namespace sheaf {

/// One value per field.
struct Scalar {
  using Float = float;
  using Uint = std::uint32_t;
  using Mask = bool;
  static constexpr int width = 1;
  static SHEAF_INLINE Mask first(int count) { return count > 0; }
  static SHEAF_INLINE Uint index() { return 0; }
};

/// kWidth values per field: one register.
struct Wide {
  using Float = WideFloat;
  using Uint = WideUint;
  using Mask = WideMask;
  static constexpr int width = kWidth;
  static SHEAF_INLINE Mask first(int count) { return first_lanes(count); }
  static SHEAF_INLINE Uint index() { return lane_index(); }
};

/// Storage: every field of a record is a pointer to a column. Loads yield Scalar or Wide values.
struct Columns {
  using Float = float*;
  using Uint = std::uint32_t*;
};

template <class L> using Float = typename L::Float;
template <class L> using Uint = typename L::Uint;
template <class L> using Mask = typename L::Mask;

inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kInvPi = 0.31830988618379067154f;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// The largest float below 1.
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

/// a squared.
template <class F> SHEAF_INLINE F sqr(F a) { return a * a; }
/// sqrt(max(a, 0)).
template <class F> SHEAF_INLINE F safe_sqrt(F a) { return sqrt(max(a, F(0.0f))); }
template <class F> SHEAF_INLINE F clamp(F a, F lo, F hi) { return min(max(a, lo), hi); }
/// a + t (b - a).
template <class F> SHEAF_INLINE F lerp(F t, F a, F b) { return fma(t, b - a, a); }

}  // namespace sheaf

// Vectors and points of three and two components, generic in the lane.
#pragma once

#include "core/simd/lanes.h"

#include <tuple>

namespace sheaf {

template <class L> struct Vec2 {
  typename L::Float x{}, y{};
  static constexpr auto fields(auto& s) { return std::tie(s.x, s.y); }
};

template <class L> struct Vec3 {
  typename L::Float x{}, y{}, z{};
  static constexpr auto fields(auto& s) { return std::tie(s.x, s.y, s.z); }
};

using Vec2f = Vec2<Scalar>;
using Vec3f = Vec3<Scalar>;

template <class L> SHEAF_INLINE Vec3<L> operator+(Vec3<L> a, Vec3<L> b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
template <class L> SHEAF_INLINE Vec3<L> operator-(Vec3<L> a, Vec3<L> b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
template <class L> SHEAF_INLINE Vec3<L> operator*(Vec3<L> a, Vec3<L> b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
template <class L> SHEAF_INLINE Vec3<L> operator-(Vec3<L> a) { return {-a.x, -a.y, -a.z}; }
template <class L> SHEAF_INLINE Vec3<L> operator*(Vec3<L> a, typename L::Float s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class L> SHEAF_INLINE Vec3<L> operator*(typename L::Float s, Vec3<L> a) { return a * s; }
template <class L> SHEAF_INLINE Vec3<L> operator/(Vec3<L> a, typename L::Float s) {
  return a * (typename L::Float(1.0f) / s);
}
SHEAF_INLINE bool operator==(Vec3f a, Vec3f b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

template <class L> SHEAF_INLINE Float<L> dot(Vec3<L> a, Vec3<L> b) { return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z)); }
template <class L> SHEAF_INLINE Vec3<L> cross(Vec3<L> a, Vec3<L> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class L> SHEAF_INLINE Float<L> length_squared(Vec3<L> a) { return dot(a, a); }
template <class L> SHEAF_INLINE Float<L> length(Vec3<L> a) { return sqrt(dot(a, a)); }
template <class L> SHEAF_INLINE Vec3<L> normalize(Vec3<L> a) { return a * (Float<L>(1.0f) / sqrt(dot(a, a))); }
/// `w` mirrored at the unit vector `m`: both include the same angle with it.
template <class L> SHEAF_INLINE Vec3<L> reflect(Vec3<L> w, Vec3<L> m) { return m * (Float<L>(2.0f) * dot(w, m)) - w; }
template <class L> SHEAF_INLINE Vec3<L> abs(Vec3<L> a) { return {abs(a.x), abs(a.y), abs(a.z)}; }
template <class L> SHEAF_INLINE Float<L> max_component(Vec3<L> a) { return max(a.x, max(a.y, a.z)); }
template <class L> SHEAF_INLINE Vec3<L> select(Mask<L> m, Vec3<L> a, Vec3<L> b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
template <class L> SHEAF_INLINE Mask<L> is_finite(Vec3<L> a) {
  return is_finite(a.x) & is_finite(a.y) & is_finite(a.z);
}
/// The same vector in every lane.
template <class L> SHEAF_INLINE Vec3<L> broadcast(Vec3f a) { return {Float<L>(a.x), Float<L>(a.y), Float<L>(a.z)}; }

}  // namespace sheaf

// Points and vectors in double precision, for descriptions of scenes. Kernels use Vec3<L>.
#pragma once

#include "core/math/vec.h"

#include <array>
#include <cmath>

namespace sheaf {

/// A point or a vector in double precision: keeps the digits of positions far from the origin.
struct Vec3d {
  double x = 0, y = 0, z = 0;

  constexpr Vec3d() = default;
  constexpr Vec3d(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
  constexpr Vec3d(Vec3f v) : x(double{v.x}), y(double{v.y}), z(double{v.z}) {}  // NOLINT: loses nothing

  /// Rounded to single precision.
  Vec3f rounded() const { return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)}; }

  friend constexpr Vec3d operator+(Vec3d a, Vec3d b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3d operator-(Vec3d a, Vec3d b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3d operator-(Vec3d a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3d operator*(Vec3d a, double s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr bool operator==(Vec3d a, Vec3d b) = default;
};

/// The same for algorithms that reach components by index.
using Triple = std::array<double, 3>;

inline double dot(Vec3d a, Vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3d cross(Vec3d a, Vec3d b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3d a) { return std::sqrt(dot(a, a)); }
inline bool is_finite(Vec3d a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

}  // namespace sheaf

// Affine and projective transforms: a 4x4 matrix with its inverse.
#pragma once

#include "core/math/vec3d.h"

#include <array>

namespace sheaf {

/// A 4x4 matrix in row-major order, for column vectors.
struct Matrix4 {
  std::array<std::array<double, 4>, 4> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
};
Matrix4 operator*(const Matrix4& a, const Matrix4& b);
/// Computes the inverse. Returns false if the matrix is singular or not finite.
bool invert(const Matrix4& a, Matrix4& out);

/// A transform with its inverse. Composition multiplies in double precision.
class Transform {
 public:
  Transform() = default;
  /// Throws Error if the matrix is singular or not finite.
  explicit Transform(const Matrix4& matrix);

  /// Throws Error if `by` is not finite.
  static Transform translate(Vec3d by);
  /// Throws Error if a factor is zero or not finite.
  static Transform scale(Vec3d by);
  /// A counter-clockwise rotation about `axis` (any length but zero), in degrees. Throws Error if the axis is zero or
  /// not finite.
  static Transform rotate(Vec3d axis, double degrees);
  /// Camera to world: +z points from `origin` to `target`, +y is nearest to `up`, and +x points to the left of the
  /// image. Throws Error if the directions coincide.
  static Transform look_at(Vec3d origin, Vec3d target, Vec3d up);

  Transform inverse() const;
  /// First `b`, then `*this`.
  Transform operator*(const Transform& b) const;

  Vec3f point(Vec3f p) const;
  /// point() without rounding to single precision. Affine transforms only.
  Vec3d precise_point(Vec3d p) const;
  /// The image of the origin under an affine transform.
  Vec3d translation() const { return {matrix_.m[0][3], matrix_.m[1][3], matrix_.m[2][3]}; }
  Vec3f vector(Vec3f v) const;
  /// A normal, by the inverse transpose; not normalized.
  Vec3f normal(Vec3f n) const;
  const Matrix4& matrix() const { return matrix_; }
  const Matrix4& inverse_matrix() const { return inverse_; }
  /// Whether the transform turns right-handed frames into left-handed ones.
  bool swaps_handedness() const;

 private:
  Matrix4 matrix_, inverse_;
};

}  // namespace sheaf

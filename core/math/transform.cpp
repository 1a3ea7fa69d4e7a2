// Inversion of matrices, and construction and application of transforms.
#include "core/math/transform.h"

#include "core/io/error.h"

namespace sheaf {

Matrix4 operator*(const Matrix4& a, const Matrix4& b) {
  Matrix4 r;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      r.m[i][j] = 0;
      for (int k = 0; k < 4; ++k) r.m[i][j] += a.m[i][k] * b.m[k][j];
    }
  return r;
}

bool invert(const Matrix4& a, Matrix4& out) {
  // Gauss-Jordan elimination with row pivoting.
  Matrix4 left = a, right;
  for (int column = 0; column < 4; ++column) {
    int pivot = column;
    for (int row = column + 1; row < 4; ++row)
      if (std::fabs(left.m[row][column]) > std::fabs(left.m[pivot][column])) pivot = row;
    const double p = left.m[pivot][column];
    if (!std::isfinite(p) || p == 0.0) return false;
    std::swap(left.m[pivot], left.m[column]);
    std::swap(right.m[pivot], right.m[column]);
    for (int j = 0; j < 4; ++j) {
      left.m[column][j] /= p;
      right.m[column][j] /= p;
    }
    for (int row = 0; row < 4; ++row) {
      if (row == column) continue;
      const double factor = left.m[row][column];
      for (int j = 0; j < 4; ++j) {
        left.m[row][j] -= factor * left.m[column][j];
        right.m[row][j] -= factor * right.m[column][j];
      }
    }
  }
  for (const auto& row : right.m)
    for (double x : row)
      if (!std::isfinite(x)) return false;
  out = right;
  return true;
}

Transform::Transform(const Matrix4& matrix) : matrix_(matrix) {
  if (!invert(matrix, inverse_)) throw SceneError("transform is not invertible");
}

Transform Transform::translate(Vec3d by) {
  if (!is_finite(by)) throw SceneError("translation must be finite");
  Transform t;
  const double v[3] = {by.x, by.y, by.z};
  for (int i = 0; i < 3; ++i) {
    t.matrix_.m[i][3] = v[i];
    t.inverse_.m[i][3] = -v[i];
  }
  return t;
}

Transform Transform::scale(Vec3d by) {
  Matrix4 m;
  m.m[0][0] = by.x;
  m.m[1][1] = by.y;
  m.m[2][2] = by.z;
  return Transform(m);
}

Transform Transform::rotate(Vec3d axis, double degrees) {
  const double norm = length(axis);
  if (!(norm > 0.0) || !std::isfinite(norm)) throw SceneError("rotation axis must not be zero");
  const double u[3] = {axis.x / norm, axis.y / norm, axis.z / norm};
  const double angle = degrees * (3.14159265358979323846 / 180.0), c = std::cos(angle), s = std::sin(angle);
  Matrix4 m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m.m[i][j] = u[i] * u[j] * (1.0 - c) + (i == j ? c : 0.0);
  m.m[0][1] -= u[2] * s;
  m.m[0][2] += u[1] * s;
  m.m[1][0] += u[2] * s;
  m.m[1][2] -= u[0] * s;
  m.m[2][0] -= u[1] * s;
  m.m[2][1] += u[0] * s;
  return Transform(m);
}

namespace {

/// Normalizes `v`. Double precision serves scenes of any size within the range of float.
Vec3d unit(Vec3d v) {
  const double norm = length(v);
  if (!(norm > 0.0) || !std::isfinite(norm)) throw SceneError("lookat: origin, target and up must span a frame");
  return {v.x / norm, v.y / norm, v.z / norm};
}

}  // namespace

Transform Transform::look_at(Vec3d origin, Vec3d target, Vec3d up) {
  const Vec3d forward = unit(target - origin);
  const Vec3d left = unit(cross(unit(up), forward));
  const Vec3d columns[4] = {left, cross(forward, left), forward, origin};
  Matrix4 m;
  for (std::size_t j = 0; j < 4; ++j) {
    m.m[0][j] = columns[j].x;
    m.m[1][j] = columns[j].y;
    m.m[2][j] = columns[j].z;
  }
  return Transform(m);
}

Transform Transform::inverse() const {
  Transform t;
  t.matrix_ = inverse_;
  t.inverse_ = matrix_;
  return t;
}

Transform Transform::operator*(const Transform& b) const {
  Transform t;
  t.matrix_ = matrix_ * b.matrix_;
  t.inverse_ = b.inverse_ * inverse_;
  return t;
}

namespace {
/// Rows 0..2 of m times (v, w).
Vec3f apply(const Matrix4& m, Vec3f v, double w) {
  double r[3];
  for (int i = 0; i < 3; ++i) r[i] = m.m[i][0] * v.x + m.m[i][1] * v.y + m.m[i][2] * v.z + m.m[i][3] * w;
  return {static_cast<float>(r[0]), static_cast<float>(r[1]), static_cast<float>(r[2])};
}
}  // namespace

Vec3f Transform::point(Vec3f p) const {
  const Vec3f r = apply(matrix_, p, 1.0);
  const auto& row = matrix_.m[3];
  const double w = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
  return w == 1.0 ? r : r / static_cast<float>(w);
}

Vec3d Transform::precise_point(Vec3d p) const {
  const auto row = [&](std::size_t i) {
    return matrix_.m[i][0] * p.x + matrix_.m[i][1] * p.y + matrix_.m[i][2] * p.z + matrix_.m[i][3];
  };
  return {row(0), row(1), row(2)};
}

Vec3f Transform::vector(Vec3f v) const { return apply(matrix_, v, 0.0); }

Vec3f Transform::normal(Vec3f n) const {
  Matrix4 transposed;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) transposed.m[i][j] = inverse_.m[j][i];
  return apply(transposed, n, 0.0);
}

bool Transform::swaps_handedness() const {
  const auto& m = matrix_.m;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
         0.0;
}

}  // namespace sheaf

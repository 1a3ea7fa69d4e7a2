#include "scene/tables/quadric.h"

#include <array>
#include <cmath>

namespace sheaf {

namespace {

using Vec3d = std::array<double, 3>;

double dot3(const Vec3d& a, const Vec3d& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Rows of a 3x4 matrix times (v, w).
Vec3d apply(const float* m, const Vec3d& v, double w) {
  Vec3d r;
  for (std::size_t i = 0; i < 3; ++i)
    r[i] = m[4 * i] * v[0] + m[4 * i + 1] * v[1] + m[4 * i + 2] * v[2] + m[4 * i + 3] * w;
  return r;
}

/// Normals by the inverse transpose of the linear part.
Vec3d apply_normal(const float* to_object, const Vec3d& n) {
  Vec3d r;
  for (std::size_t i = 0; i < 3; ++i) r[i] = to_object[i] * n[0] + to_object[4 + i] * n[1] + to_object[8 + i] * n[2];
  return r;
}

/// Roots t0 <= t1 of |o + t d|^2 = 1 over the first `n` coordinates; false if there are none. The discriminant is
/// taken from the closest point to the axis or centre, which keeps it exact for far origins.
bool unit_roots(const Vec3d& o, const Vec3d& d, std::size_t n, double& t0, double& t1) {
  double a = 0, b = 0;
  for (std::size_t i = 0; i < n; ++i) {
    a += d[i] * d[i];
    b += o[i] * d[i];
  }
  if (!(a > 0.0)) return false;
  double nearest = 0, c = -1;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = o[i] - b / a * d[i];
    nearest += x * x;
    c += o[i] * o[i];
  }
  const double discriminant = a * (1.0 - nearest);
  if (discriminant < 0.0) return false;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  t0 = q / a;
  t1 = q != 0.0 ? c / q : t0;
  if (t0 > t1) std::swap(t0, t1);
  return true;
}

}  // namespace

QuadricRow make_quadric(ShapeKind kind, const Transform& to_world, bool flip_normals) {
  QuadricRow row{};
  row.kind = kind;
  const auto& m = to_world.matrix().m;
  const auto& inverse = to_world.inverse_matrix().m;
  if (m[3][0] != 0.0 || m[3][1] != 0.0 || m[3][2] != 0.0) throw SceneError("shapes need an affine transform");
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      row.to_world[4 * i + j] = static_cast<float>(m[i][j] / m[3][3]);
      row.to_object[4 * i + j] = static_cast<float>(inverse[i][j] / inverse[3][3]);
    }
  double det = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    det += m[0][i] * (m[1][j] * m[2][k] - m[1][k] * m[2][j]);
  }
  det /= m[3][3] * m[3][3] * m[3][3];
  row.normal_sign = flip_normals ? -1.0f : 1.0f;
  row.determinant = static_cast<float>(std::fabs(det));
  const double factor = std::cbrt(std::fabs(det));
  bool similar = true;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double product = m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j];
      similar = similar && std::fabs(product - (i == j ? factor * factor : 0.0)) <= 1e-5 * factor * factor;
    }
  row.uniform_scale = similar ? static_cast<float>(factor) : 0.0f;
  return row;
}

QuadricBounds quadric_bounds(const QuadricRow& row) {
  double lower[3], upper[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const float* r = row.to_world + 4 * i;
    const double disk = std::hypot(double(r[0]), double(r[1]));
    const double sphere = std::hypot(disk, double(r[2]));
    const double extent = row.kind == ShapeKind::kSphere ? sphere : disk;
    const double z0 = r[3], z1 = row.kind == ShapeKind::kCylinder ? double(r[3]) + r[2] : double(r[3]);
    const double slack = 4e-7 * (std::fabs(z0) + std::fabs(z1) + sphere);
    lower[i] = std::min(z0, z1) - extent - slack;
    upper[i] = std::max(z0, z1) + extent + slack;
  }
  const auto vec = [](const double* v) {
    return Vec3f{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
  };
  return {vec(lower), vec(upper)};
}

std::optional<QuadricHit> intersect_quadric(const QuadricRow& row, Vec3f origin, Vec3f direction, float t_near,
                                            float t_far) noexcept {
  const Vec3d o = apply(row.to_object, {origin.x, origin.y, origin.z}, 1.0);
  const Vec3d d = apply(row.to_object, {direction.x, direction.y, direction.z}, 0.0);
  double roots[2];
  int count = 0;
  if (row.kind == ShapeKind::kDisk) {
    if (d[2] != 0.0) roots[count++] = -o[2] / d[2];
  } else if (unit_roots(o, d, row.kind == ShapeKind::kSphere ? 3 : 2, roots[0], roots[1])) {
    count = 2;
  }
  for (int i = 0; i < count; ++i) {
    const float t = static_cast<float>(roots[i]);
    if (!(t > t_near && t < t_far)) continue;
    Vec3d p{o[0] + roots[i] * d[0], o[1] + roots[i] * d[1], o[2] + roots[i] * d[2]};
    if (row.kind == ShapeKind::kCylinder) {
      if (p[2] < 0.0 || p[2] > 1.0) continue;
      p[2] = 0.0;
    } else if (row.kind == ShapeKind::kDisk) {
      if (p[0] * p[0] + p[1] * p[1] > 1.0) continue;
      p = {0.0, 0.0, 1.0};
    }
    const Vec3d n = apply_normal(row.to_object, p);
    const double sign = row.normal_sign / std::sqrt(std::max(dot3(n, n), 1e-300));
    return QuadricHit{
        t, {static_cast<float>(n[0] * sign), static_cast<float>(n[1] * sign), static_cast<float>(n[2] * sign)}};
  }
  return std::nullopt;
}

float canonical_area(ShapeKind kind) {
  return kind == ShapeKind::kSphere ? 4 * kPi : kind == ShapeKind::kDisk ? kPi : 2 * kPi;
}

float quadric_area(const QuadricRow& row) {
  // The area element scales by |det| |M^-T n|; midpoint rule over the normals of the canonical shape.
  const auto factor = [&row](const Vec3d& n) {
    const Vec3d t = apply_normal(row.to_object, n);
    return row.determinant * std::sqrt(dot3(t, t));
  };
  if (row.kind == ShapeKind::kDisk) return static_cast<float>(kPi * factor({0, 0, 1}));
  constexpr int kSteps = 64;
  double sum = 0;
  const int rings = row.kind == ShapeKind::kSphere ? kSteps : 1;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < 2 * kSteps; ++j) {
      const double z = row.kind == ShapeKind::kSphere ? (2 * i + 1.0) / kSteps - 1.0 : 0.0;
      const double phi = (j + 0.5) * 3.14159265358979323846 / kSteps, r = std::sqrt(1 - z * z);
      sum += factor({r * std::cos(phi), r * std::sin(phi), z});
    }
  return static_cast<float>(canonical_area(row.kind) * sum / (rings * 2.0 * kSteps));
}

}  // namespace sheaf

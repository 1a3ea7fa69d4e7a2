#include "scene/accel/quadric.h"

#include "core/io/error.h"
#include "core/math/vec3d.h"

#include <array>
#include <cmath>

namespace sheaf {

namespace {

double dot_product(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Multiplies a 3x4 matrix, given by rows, with (v, w).
Triple apply(const float* m, const Triple& v, double w) {
  Triple r;
  for (std::size_t i = 0; i < 3; ++i)
    r[i] = m[4 * i] * v[0] + m[4 * i + 1] * v[1] + m[4 * i + 2] * v[2] + m[4 * i + 3] * w;
  return r;
}

/// Transforms a normal by the inverse transpose of the linear part.
Triple apply_normal(const float* to_object, const Triple& n) {
  Triple r;
  for (std::size_t i = 0; i < 3; ++i) r[i] = to_object[i] * n[0] + to_object[4 + i] * n[1] + to_object[8 + i] * n[2];
  return r;
}

/// Roots t0 <= t1 of |o + t d|^2 = 1 over the first `n` coordinates; false if there are none. The discriminant is
/// computed from the point closest to the axis or center, which stays accurate for distant origins.
bool unit_roots(const Triple& o, const Triple& d, std::size_t n, double& t0, double& t1) {
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

/// Squared semi-axes, ascending, of the image of the unit circle under the matrix with columns u and v, after a leading
/// 0.
Triple squared_axes(const Triple& u, const Triple& v) {
  const double mean = 0.5 * (dot_product(u, u) + dot_product(v, v)),
               half = 0.5 * (dot_product(u, u) - dot_product(v, v));
  const double larger = mean + std::hypot(half, dot_product(u, v));
  const Triple across{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  return {0.0, dot_product(across, across) / larger, larger};
}

/// Squared semi-axes of the image of the unit sphere under the matrix with these columns. One-sided Jacobi rotations
/// (Hestenes 1958) compute small axes accurately.
Triple squared_axes(const Triple (&of)[3]) {
  // One-sided Jacobi rotations until the columns are orthogonal
  Triple columns[3] = {of[0], of[1], of[2]};
  constexpr int kMaxSweeps = 30;
  bool changed = true;
  for (int sweep = 0; changed && sweep < kMaxSweeps; ++sweep) {
    changed = false;
    for (std::size_t k = 0; k < 3; ++k) {
      Triple &u = columns[k], &v = columns[(k + 1) % 3];
      const double uu = dot_product(u, u), vv = dot_product(v, v), uv = dot_product(u, v);
      if (!(std::fabs(uv) > 1e-14 * std::sqrt(uu * vv))) continue;
      changed = true;
      const double zeta = (vv - uu) / (2 * uv);
      const double t = std::copysign(1.0, zeta) / (std::fabs(zeta) + std::hypot(1.0, zeta));
      const double c = 1 / std::hypot(1.0, t), s = c * t;
      for (std::size_t i = 0; i < 3; ++i) {
        const double before = u[i];
        u[i] = c * before - s * v[i];
        v[i] = s * before + c * v[i];
      }
    }
  }
  return {dot_product(columns[0], columns[0]), dot_product(columns[1], columns[1]),
          dot_product(columns[2], columns[2])};
}

/// Carlson's symmetric elliptic integral of the second kind, R_G(x, y, z): the mean of the square root of x n_x^2 + y
/// n_y^2 + z n_z^2 over directions n. No argument may be negative; at most one may be zero. Computed from R_F and R_D
/// by the duplication theorem (Carlson, "Numerical Computation of Real or Complex Elliptic Integrals", 1995).
double carlson_rg(double x, double y, double z) {
  // With the middle argument as z, no term is negative (NIST Digital Library of Mathematical Functions, equation
  // 19.21.10).
  if (x > y) std::swap(x, y);
  if (y > z) std::swap(y, z);
  if (x > y) std::swap(x, y);
  std::swap(y, z);
  const double first = std::sqrt(x * y / z), outer = (x - z) * (y - z) / 3;
  const double middle = z;
  // With arguments within 1e-3 of their mean, the fifth-order series has a relative error below 1e-17.
  double sum = 0, factor = 1;
  double mean = 0;
  for (;;) {
    mean = (x + y + 3 * z) / 5;
    const double worst = std::max({std::fabs(mean - x), std::fabs(mean - y), std::fabs(mean - z)});
    if (worst < 1e-3 * mean) break;
    const double lambda = std::sqrt(x * y) + std::sqrt(y * z) + std::sqrt(z * x);
    sum += factor / (std::sqrt(z) * (z + lambda));
    factor *= 0.25;
    x = 0.25 * (x + lambda), y = 0.25 * (y + lambda), z = 0.25 * (z + lambda);
  }
  const double dx = (mean - x) / mean, dy = (mean - y) / mean, dz = -(dx + dy) / 3;
  const double d2 = dx * dy - 6 * dz * dz, d3 = (3 * dx * dy - 8 * dz * dz) * dz,
               d4 = 3 * (dx * dy - dz * dz) * dz * dz, d5 = dx * dy * dz * dz * dz;
  const double rd =
      3 * sum + factor * (1 - 3 * d2 / 14 + d3 / 6 + 9 * d2 * d2 / 88 - 3 * d4 / 22 - 9 * d2 * d3 / 52 + 3 * d5 / 26) /
                    (mean * std::sqrt(mean));
  const double third = (x + y + z) / 3;
  const double ex = (third - x) / third, ey = (third - y) / third, ez = -ex - ey;
  const double e2 = ex * ey - ez * ez, e3 = ex * ey * ez;
  const double rf = (1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44) / std::sqrt(third);
  return 0.5 * (middle * rf - outer * rd + first);
}

}  // namespace

QuadricRow make_quadric(ShapeKind kind, const Transform& to_world, bool flip_normals) {
  QuadricRow row{};
  row.kind = kind;
  const auto& m = to_world.matrix().m;
  const auto& inverse = to_world.inverse_matrix().m;
  // Copy the matrices
  if (m[3][0] != 0.0 || m[3][1] != 0.0 || m[3][2] != 0.0) throw SceneError("shapes need an affine transform");
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      row.to_world[4 * i + j] = static_cast<float>(m[i][j] / m[3][3]);
      row.to_object[4 * i + j] = static_cast<float>(inverse[i][j] / inverse[3][3]);
    }
  // Compute the determinant
  double det = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    det += m[0][i] * (m[1][j] * m[2][k] - m[1][k] * m[2][j]);
  }
  det /= m[3][3] * m[3][3] * m[3][3];
  row.normal_sign = flip_normals ? -1.0f : 1.0f;
  row.determinant = static_cast<float>(std::fabs(det));
  // Find out whether the transform is a similarity
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

Bounds3f quadric_bounds(const QuadricRow& row) {
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
  const Triple o = apply(row.to_object, {origin.x, origin.y, origin.z}, 1.0);
  const Triple d = apply(row.to_object, {direction.x, direction.y, direction.z}, 0.0);
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
    Triple p{o[0] + roots[i] * d[0], o[1] + roots[i] * d[1], o[2] + roots[i] * d[2]};
    if (row.kind == ShapeKind::kCylinder) {
      if (p[2] < 0.0 || p[2] > 1.0) continue;
      p[2] = 0.0;
    } else if (row.kind == ShapeKind::kDisk) {
      if (p[0] * p[0] + p[1] * p[1] > 1.0) continue;
      p = {0.0, 0.0, 1.0};
    }
    const Triple n = apply_normal(row.to_object, p);
    const double sign = row.normal_sign / std::sqrt(std::max(dot_product(n, n), 1e-300));
    return QuadricHit{
        t, {static_cast<float>(n[0] * sign), static_cast<float>(n[1] * sign), static_cast<float>(n[2] * sign)}};
  }
  return std::nullopt;
}

float canonical_area(ShapeKind kind) {
  return kind == ShapeKind::kSphere ? 4 * kPi : kind == ShapeKind::kDisk ? kPi : 2 * kPi;
}

float quadric_area(const QuadricRow& row) {
  if (row.uniform_scale > 0.0f) return canonical_area(row.kind) * sqr(row.uniform_scale);
  // The area element of the canonical shape with normal n scales by |C n|, with C = |det| M^-T.
  Triple columns[3];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) columns[i][j] = double{row.determinant} * double{row.to_object[4 * i + j]};
  if (row.kind == ShapeKind::kDisk)
    return static_cast<float>(double(kPi) * std::sqrt(dot_product(columns[2], columns[2])));
  const Triple squares = row.kind == ShapeKind::kSphere ? squared_axes(columns) : squared_axes(columns[0], columns[1]);
  // An ellipsoid with semi-axes a, b, c has the area 4 pi R_G(a^2 b^2, a^2 c^2, b^2 c^2). An ellipse with semi-axes a,
  // b has the perimeter 8 R_G(0, a^2, b^2) (NIST Digital Library of Mathematical Functions, 19.33.1 and 19.30.5).
  const double factor = row.kind == ShapeKind::kSphere ? 4 * double(kPi) : 8.0;
  return static_cast<float>(factor * carlson_rg(squares[0], squares[1], squares[2]));
}

}  // namespace sheaf

// Spheres, disks and cylinders: intersections against a numerical search, bounds, and areas.
#include "scene/accel/quadric.h"

#include "core/io/error.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/test_transforms.h"

#include <doctest/doctest.h>

#include <cmath>
#include <optional>
#include <vector>

namespace sheaf::test_quadric {

namespace {

constexpr ShapeKind kKinds[] = {ShapeKind::kSphere, ShapeKind::kDisk, ShapeKind::kCylinder};

struct Ray {
  Vec3f origin, direction;
  Vec3f at(double t) const { return origin + direction * static_cast<float>(t); }
};

/// A ray that passes near the shape, from outside or from inside.
Ray random_ray(const Transform& to_world, std::uint32_t i) {
  const auto u = random4<Scalar>(31, i, 2, 0);
  const Vec3f target = to_world.point(random_direction(32, i) * u.x);
  const Vec3f origin = to_world.point(random_direction(33, i) * (u.y < 0.3f ? u.z : 1.0f + 9.0f * u.z));
  return {origin, normalize(target - origin)};
}

/// Zero on the canonical surface, with different signs on its sides.
double side(ShapeKind kind, const std::array<double, 3>& x) {
  if (kind == ShapeKind::kDisk) return x[2];
  return x[0] * x[0] + x[1] * x[1] + (kind == ShapeKind::kSphere ? x[2] * x[2] : 0.0) - 1;
}
bool inside_limits(ShapeKind kind, const std::array<double, 3>& x) {
  if (kind == ShapeKind::kDisk) return x[0] * x[0] + x[1] * x[1] <= 1;
  return kind == ShapeKind::kSphere || (x[2] >= 0 && x[2] <= 1);
}

/// Looks for sign changes along the ray in small steps and bisects the first one inside the limits.
std::optional<double> search(ShapeKind kind, const Transform& to_world, const Ray& ray, double t_near, double t_far) {
  const auto& m = to_world.inverse_matrix().m;
  const auto object = [&](double t) {
    std::array<double, 3> x{};
    const double p[4] = {ray.origin.x + t * ray.direction.x, ray.origin.y + t * ray.direction.y,
                         ray.origin.z + t * ray.direction.z, 1};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 4; ++j) x[i] += m[i][j] * p[j];
    return x;
  };
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    double a = t_near + (t_far - t_near) * i / kSteps, b = t_near + (t_far - t_near) * (i + 1) / kSteps;
    const bool before = side(kind, object(a)) > 0;
    if (before == (side(kind, object(b)) > 0)) continue;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (a + b);
      ((side(kind, object(middle)) > 0) == before ? a : b) = middle;
    }
    if (inside_limits(kind, object(a))) return a;
  }
  return std::nullopt;
}

/// A point of the canonical surface.
Vec3f canonical_point(ShapeKind kind, std::uint32_t i) {
  const auto u = random4<Scalar>(35, i, 0, 0);
  const Vec3f d = random_direction(36, i);
  if (kind == ShapeKind::kSphere) return d;
  const float angle = 2 * kPi * u.x, r = kind == ShapeKind::kDisk ? std::sqrt(u.y) : 1.0f;
  return {r * std::cos(angle), r * std::sin(angle), kind == ShapeKind::kDisk ? 0.0f : u.z};
}

}  // namespace

TEST_CASE("quadric: intersections match a search along the ray") {
  constexpr float kFar = 60;
  for (const ShapeKind kind : kKinds)
    for (const Transform& to_world : test_transforms()) {
      CAPTURE(static_cast<int>(kind));
      const QuadricRow row = make_quadric(kind, to_world, false);
      int hits = 0, disagreements = 0;
      double worst = 0;
      for (std::uint32_t i = 0; i < 400; ++i) {
        const Ray ray = random_ray(to_world, i);
        const auto found = intersect_quadric(row, ray.origin, ray.direction, 0, kFar);
        const auto expected = search(kind, to_world, ray, 0, kFar);
        if (found.has_value() != expected.has_value()) {
          ++disagreements;
          continue;
        }
        if (!found) continue;
        ++hits;
        worst = std::max(worst, std::fabs(found->t - *expected));
      }
      CHECK(hits > 100);
      // Rays that graze a surface or its rim within a step of the search, or within rounding.
      CHECK(disagreements <= 3);
      CHECK(worst < 1e-4);
    }
}

TEST_CASE("quadric: normals are perpendicular to the surface and face outwards unless flipped") {
  for (const ShapeKind kind : kKinds)
    for (const Transform& to_world : test_transforms())
      for (const bool flip : {false, true}) {
        const QuadricRow row = make_quadric(kind, to_world, flip);
        int hits = 0;
        for (std::uint32_t i = 0; i < 300; ++i) {
          const Ray ray = random_ray(to_world, i);
          const auto found = intersect_quadric(row, ray.origin, ray.direction, 0, kInfinity);
          if (!found) continue;
          ++hits;
          const Vec3f n = normalize(found->normal), x = to_world.inverse().point(ray.at(found->t));
          const Vec3f canonical = kind == ShapeKind::kDisk     ? Vec3f{0, 0, 1}
                                  : kind == ShapeKind::kSphere ? x
                                                               : Vec3f{x.x, x.y, 0};
          const Vec3f expected = normalize(to_world.normal(canonical)) * (flip ? -1.0f : 1.0f);
          CHECK(record_difference<Vec3>(n, expected) < 1e-4);
          // Tangents of the canonical surface remain tangents.
          const Vec3f tangent =
              normalize(to_world.vector(kind == ShapeKind::kDisk ? Vec3f{1, 0, 0} : Vec3f{-x.y, x.x, 0}));
          CHECK(std::fabs(dot(n, tangent)) < 1e-4f);
        }
        CHECK(hits > 100);
      }
}

TEST_CASE("quadric: hits lie strictly within the given interval") {
  const QuadricRow row = make_quadric(ShapeKind::kSphere, Transform(), false);
  const Vec3f origin{0, 0, -3}, direction{0, 0, 1};
  CHECK(intersect_quadric(row, origin, direction, 0, kInfinity)->t == 2.0f);
  CHECK(intersect_quadric(row, origin, direction, 2.0f, kInfinity)->t == 4.0f);
  CHECK_FALSE(intersect_quadric(row, origin, direction, 0, 2.0f).has_value());
  CHECK_FALSE(intersect_quadric(row, origin, direction, 4.0f, kInfinity).has_value());
  CHECK_FALSE(intersect_quadric(row, origin, {0, 0, -1}, 0, kInfinity).has_value());
  CHECK(intersect_quadric(row, {0, 0, 0}, direction, 0, kInfinity)->t == 1.0f);
  CHECK(intersect_quadric(row, origin, {0, 0, 0.5f}, 0, kInfinity)->t == 4.0f);
}

TEST_CASE("quadric: rays in the plane of a disk or along the axis of a cylinder miss") {
  const QuadricRow disk = make_quadric(ShapeKind::kDisk, Transform(), false);
  CHECK_FALSE(intersect_quadric(disk, {-3, 0, 0}, {1, 0, 0}, 0, kInfinity).has_value());
  CHECK_FALSE(intersect_quadric(disk, {0, 1.01f, 1}, {0, 0, -1}, 0, kInfinity).has_value());
  const QuadricRow cylinder = make_quadric(ShapeKind::kCylinder, Transform(), false);
  CHECK_FALSE(intersect_quadric(cylinder, {0.5f, 0, -1}, {0, 0, 1}, 0, kInfinity).has_value());
  // Enters at the open end and leaves through the side.
  CHECK(intersect_quadric(cylinder, {0, 0, -1}, normalize(Vec3f{0.6f, 0, 1}), 0, kInfinity)->t ==
        near(std::hypot(1, 1 / 0.6), 1e-5));
}

TEST_CASE("quadric: a small distant sphere is hit at its position") {
  for (const float distance : {1e2f, 1e4f, 1e6f}) {
    const QuadricRow row = make_quadric(ShapeKind::kSphere, Transform(), false);
    const auto hit = intersect_quadric(row, {0.5f, 0, -distance}, {0, 0, 1}, 0, kInfinity);
    REQUIRE(hit.has_value());
    CHECK(hit->t == near(double(distance) - std::sqrt(0.75), 1e-7));
    CHECK(normalize(hit->normal).x == near(0.5, 1e-5));
  }
}

TEST_CASE("quadric: bounds contain the shape tightly") {
  for (const ShapeKind kind : kKinds)
    for (const Transform& to_world : test_transforms()) {
      const Bounds3f bounds = quadric_bounds(make_quadric(kind, to_world, false));
      Vec3f lower{kInfinity, kInfinity, kInfinity}, upper = -lower;
      for (std::uint32_t i = 0; i < 20000; ++i) {
        const Vec3f p = to_world.point(canonical_point(kind, i));
        lower = {min(lower.x, p.x), min(lower.y, p.y), min(lower.z, p.z)};
        upper = {max(upper.x, p.x), max(upper.y, p.y), max(upper.z, p.z)};
      }
      const float slack = 0.03f * max_component(upper - lower);
      for (const auto& [low, least, most, high] : {std::array{bounds.min.x, lower.x, upper.x, bounds.max.x},
                                                   std::array{bounds.min.y, lower.y, upper.y, bounds.max.y},
                                                   std::array{bounds.min.z, lower.z, upper.z, bounds.max.z}}) {
        CHECK(low <= least);
        CHECK(high >= most);
        CHECK(low >= least - slack);
        CHECK(high <= most + slack);
      }
    }
}

TEST_CASE("quadric: areas of spheres and spheroids and disks and cylinders match their closed forms") {
  constexpr double kPiD = 3.14159265358979323846;
  const Transform azimuth = Transform::rotate({1, 2, 3}, 40);
  const auto area = [&](ShapeKind kind, Vec3f scale) {
    return double(quadric_area(make_quadric(kind, azimuth * Transform::scale(scale), false)));
  };
  CHECK(canonical_area(ShapeKind::kSphere) == near(4 * kPiD));
  CHECK(canonical_area(ShapeKind::kDisk) == near(kPiD));
  CHECK(canonical_area(ShapeKind::kCylinder) == near(2 * kPiD));
  CHECK(area(ShapeKind::kSphere, {3, 3, 3}) == near(36 * kPiD, 1e-5));
  CHECK(area(ShapeKind::kDisk, {2, 3, 7}) == near(6 * kPiD, 1e-5));
  CHECK(area(ShapeKind::kCylinder, {2, 2, 5}) == near(20 * kPiD, 1e-5));
  // Oblate (half axes 2, 2, 1) and prolate (1, 1, 2) spheroids.
  const double e = std::sqrt(0.75);
  CHECK(area(ShapeKind::kSphere, {2, 2, 1}) == near(2 * kPiD * 4 * (1 + 0.25 / e * std::atanh(e)), 1e-4));
  CHECK(area(ShapeKind::kSphere, {1, 1, 2}) == near(2 * kPiD * (1 + 2 / e * std::asin(e)), 1e-4));
  // Height times the perimeter of an ellipse, 4 a E(e) with the complete elliptic integral.
  CHECK(area(ShapeKind::kCylinder, {2, 1, 3}) == near(3 * 4 * 2 * std::comp_ellint_2(e), 1e-4));
}

TEST_CASE("quadric: areas under affine maps match fine meshes even for extreme proportions") {
  constexpr double kPiD = 3.14159265358979323846;
  Matrix4 shear;
  shear.m[0][1] = 0.8, shear.m[1][2] = -1.3, shear.m[2][0] = 0.4;
  const Transform maps[] = {Transform(shear), Transform::rotate({1, 2, 3}, 70) * Transform::scale({1, 2, 3}),
                            Transform::scale({0.5f, -2, 7}) * Transform(shear), Transform::scale({1, 1, 0.01f}),
                            Transform::scale({3, 0.02f, 0.01f})};
  for (const Transform& map : maps)
    for (const ShapeKind kind : {ShapeKind::kSphere, ShapeKind::kCylinder, ShapeKind::kDisk}) {
      CAPTURE(static_cast<int>(kind));
      // Triangles between points of the canonical shape, finer where the shape is stretched.
      constexpr int kRings = 200, kSegments = 400;
      const auto point = [&](int i, int j) {
        const double t = double(i) / kRings, phi = 2 * kPiD * j / kSegments;
        const double z = kind == ShapeKind::kSphere ? std::cos(kPiD * t) : kind == ShapeKind::kCylinder ? t : 0;
        const double r = kind == ShapeKind::kSphere ? std::sin(kPiD * t) : kind == ShapeKind::kCylinder ? 1 : t;
        const auto& m = map.matrix().m;
        std::array<double, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
          p[k] = m[k][0] * r * std::cos(phi) + m[k][1] * r * std::sin(phi) + m[k][2] * z;
        return p;
      };
      double expected = 0;
      for (int i = 0; i < kRings; ++i)
        for (int j = 0; j < kSegments; ++j) {
          const auto a = point(i, j), b = point(i + 1, j), c = point(i + 1, j + 1), d = point(i, j + 1);
          std::array<double, 3> u, v;  // the diagonals of a quadrangle: its area is half of their product
          for (std::size_t k = 0; k < 3; ++k) u[k] = c[k] - a[k], v[k] = d[k] - b[k];
          expected += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
        }
      CHECK(double(quadric_area(make_quadric(kind, map, false))) == near(expected, 2e-4));
    }
}

TEST_CASE("quadric: similarity transforms are recognized and projective ones are rejected") {
  const Transform azimuth = Transform::translate({1, 2, 3}) * Transform::rotate({1, 2, 3}, 40);
  CHECK(make_quadric(ShapeKind::kSphere, azimuth * Transform::scale({3, 3, 3}), false).uniform_scale == near(3));
  CHECK(make_quadric(ShapeKind::kSphere, azimuth * Transform::scale({-3, 3, 3}), false).uniform_scale == near(3));
  CHECK(make_quadric(ShapeKind::kSphere, azimuth * Transform::scale({3, 3, 3.01f}), false).uniform_scale == 0.0f);
  CHECK(make_quadric(ShapeKind::kSphere, azimuth * Transform::scale({1, -2, 3}), false).determinant == near(6));
  CHECK(make_quadric(ShapeKind::kSphere, Transform(), true).normal_sign == -1.0f);
  Matrix4 projective;
  projective.m[3][0] = 0.1;
  CHECK_THROWS_AS(make_quadric(ShapeKind::kSphere, Transform(projective), false), SceneError);
}

}  // namespace sheaf::test_quadric

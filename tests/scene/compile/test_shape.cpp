// Surfaces at hits: positions, normals, uv and tangents of every kind of shape, and the distribution of light samples.
#include "scene/surfaces/shape.h"

#include "scene/compile/compile.h"
#include "tests/support/chi_square.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/tiny_scenes.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

namespace sheaf::test_shape {

namespace {

const Transform kPosition = Transform::translate({0.5f, -0.25f, 2}) * Transform::rotate({2, -1, 2}, 40);
const Transform kStretch =
    Transform::translate({0.5f, -0.25f, 2}) * Transform::rotate({1, 2, 3}, 40) * Transform::scale({2, 0.7f, 1.2f});

template <class Geometry>
std::unique_ptr<Scene> lone_shape(Geometry geometry, const Transform& to_world, bool flip = false) {
  Description d = empty_scene(4, 4);
  emit(add_shape(d, std::move(geometry), to_world), 1).flip_normals = flip;
  return compile_scene(d);
}

struct Ray {
  Vec3f origin, direction;
};
/// A ray towards the neighborhood of kPosition and kStretch.
Ray random_ray(std::uint32_t i) {
  const Vec3f target = kPosition.point(random_direction(61, i) * 0.8f),
              origin = kPosition.point(random_direction(62, i) * 5.0f);
  return {origin, normalize(target - origin)};
}

/// The point of a canonical shape at a uv.
Vec3f canonical_at(ShapeKind kind, Vec2f uv) {
  const float azimuth = 2 * kPi * (kind == ShapeKind::kDisk ? uv.y : uv.x), c = std::cos(azimuth),
              s = std::sin(azimuth);
  if (kind == ShapeKind::kDisk) return {uv.x * c, uv.x * s, 0};
  if (kind == ShapeKind::kCylinder) return {c, s, uv.y};
  return {std::sin(kPi * uv.y) * c, std::sin(kPi * uv.y) * s, std::cos(kPi * uv.y)};
}

Mesh smooth_mesh() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0.3f}, {1, 1, 0}, {-1, 1, -0.2f}};
  mesh.normals = {{-0.3f, -0.3f, 1}, {0.4f, -0.2f, 1}, {0.1f, 0.3f, 1}, {-0.2f, 0.3f, 1}};
  mesh.uvs = {{0.1f, 0.1f}, {0.9f, 0.2f}, {1, 1.3f}, {-0.2f, 0.8f}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

struct Expected {
  Vec3f p, n;
  Vec2f uv;
  Vec3f tangent;
};
/// Compares the surface at the hit of one ray with values that Mitsuba 3 prints for the same shape and ray.
template <class Geometry>
void check_convention(Geometry geometry, const Transform& to_world, const Expected& expected, bool flip = false) {
  const auto scene = lone_shape(std::move(geometry), to_world, flip);
  const Vec3f origin{0.1f, 0.2f, -3}, direction = normalize(Vec3f{0.05f, -0.06f, 1});
  const auto hit = trace_ray(scene->view(), origin, direction);
  REQUIRE(hit.has_value());
  const auto y = surface_at(scene->view(), origin, direction, *hit);
  CHECK(record_difference<Vec3>(y.p, expected.p) < 1e-5);
  CHECK(record_difference<Vec3>(y.ng, expected.n) < 1e-5);
  CHECK(record_difference<Vec3>(y.ns, expected.n) < 1e-5);
  CHECK(record_difference<Vec2>(y.uv, expected.uv) < 1e-5);
  CHECK(record_difference<Vec3>(normalize(y.dp_du), expected.tangent) < 1e-5);
}

}  // namespace

TEST_CASE("shape: positions and normals and uv and tangents match Mitsuba") {
  const Transform stretched = kPosition * Transform::scale({2, 1.5f, 1});
  const CylinderShape cylinder{{0.2f, -1, 0.3f}, {-0.3f, 1.5f, 0.1f}, 0.8f};
  const Expected at_cylinder{{0.322458f, -0.06695f, 1.44917f},
                             {-0.0863406f, 0.237849f, -0.967457f},
                             {0.269436f, 0.452165f},
                             {-0.770784f, -0.631212f, -0.0863948f}};
  check_convention(SphereShape{{0.1f, 0.2f, -0.1f}, 1.5f}, kPosition,
                   {{0.276856f, -0.0122274f, 0.537124f},
                    {-0.150048f, -0.0042269f, -0.98867f},
                    {0.594973f, 0.818379f},
                    {0.886375f, -0.443565f, -0.132626f}});
  check_convention(DiskShape{}, stretched,
                   {{0.353108f, -0.10373f, 2.06217f},
                    {-0.110282f, -0.480515f, 0.870025f},
                    {0.142377f, 0.279762f},
                    {-0.678742f, 0.675869f, 0.287247f}});
  check_convention(cylinder, kPosition, at_cylinder);
  check_convention(cylinder, kPosition, {at_cylinder.p, -at_cylinder.n, at_cylinder.uv, at_cylinder.tangent}, true);
  check_convention(RectangleShape{}, stretched,
                   {{0.353108f, -0.10373f, 2.06217f},
                    {-0.110282f, -0.480515f, 0.870025f},
                    {0.486765f, 0.569948f},
                    {0.870025f, 0.376535f, 0.318243f}});
  check_convention(CubeShape{}, kPosition,
                   {{0.297139f, -0.0365663f, 0.942773f},
                    {0.110282f, 0.480515f, -0.870025f},
                    {0.565779f, 0.283708f},
                    {0.480515f, -0.79204f, -0.376535f}});
}

namespace {

/// Checks hits of random rays on a quadric: on the surface, with the right normal, and at the position of their uv.
void check_quadric(ShapeKind kind, const Scene& scene, const Transform& to_world, bool flip) {
  const SceneView view = scene.view();
  int hits = 0;
  double worst_p = 0, worst_n = 0, worst_uv = 0, worst_du = 0, worst_dv = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Ray ray = random_ray(i);
    const auto hit = trace_ray(view, ray.origin, ray.direction);
    if (!hit) continue;
    ++hits;
    const auto y = surface_at(view, ray.origin, ray.direction, *hit);
    worst_p = std::max(worst_p, double(length(y.p - (ray.origin + ray.direction * hit->t))));
    const Vec3f x = to_world.inverse().point(y.p);
    const Vec3f n = kind == ShapeKind::kDisk ? Vec3f{0, 0, 1} : kind == ShapeKind::kSphere ? x : Vec3f{x.x, x.y, 0};
    worst_n = std::max(worst_n, record_difference<Vec3>(y.ng, normalize(to_world.normal(n)) * (flip ? -1.0f : 1.0f)));
    worst_uv = std::max(worst_uv, double(length(to_world.point(canonical_at(kind, y.uv)) - y.p)));
    constexpr float kStep = 1e-3f;
    const auto derivative = [&](Vec2f step) {
      const Vec3f ahead = to_world.point(canonical_at(kind, {y.uv.x + step.x, y.uv.y + step.y}));
      const Vec3f behind = to_world.point(canonical_at(kind, {y.uv.x - step.x, y.uv.y - step.y}));
      return (ahead - behind) * (0.5f / kStep);
    };
    const Vec3f du = derivative({kStep, 0}), dv = derivative({0, kStep});
    worst_du = std::max(worst_du, double(length(y.dp_du - du) / length(du)));
    worst_dv = std::max(worst_dv, double(length(y.dp_dv - dv) / length(dv)));
    CHECK(y.ns == y.ng);
    CHECK(y.uv.x >= 0.0f);
    CHECK(y.uv.x <= 1.0f);
  }
  CHECK(hits > 300);
  CHECK(worst_p < 1e-5);
  CHECK(worst_n < 1e-4);
  CHECK(worst_uv < 2e-4);
  CHECK(worst_du < 5e-3);
  CHECK(worst_dv < 5e-3);
}

}  // namespace

TEST_CASE("shape: surfaces of quadrics are consistent at random hits") {
  for (const Transform& to_world : {kPosition, kStretch})
    for (const bool flip : {false, true}) {
      check_quadric(ShapeKind::kSphere, *lone_shape(SphereShape{}, to_world, flip), to_world, flip);
      check_quadric(ShapeKind::kDisk, *lone_shape(DiskShape{}, to_world, flip), to_world, flip);
      check_quadric(ShapeKind::kCylinder, *lone_shape(CylinderShape{}, to_world, flip), to_world, flip);
    }
}

TEST_CASE("shape: quadrics have tangents at poles and axes and centers") {
  const auto sphere = lone_shape(SphereShape{}, Transform());
  const auto disk = lone_shape(DiskShape{}, Transform());
  for (const Scene* scene : {sphere.get(), disk.get()}) {
    const auto hit = trace_ray(scene->view(), {0, 0, 5}, {0, 0, -1});
    REQUIRE(hit.has_value());
    const auto y = surface_at(scene->view(), {0, 0, 5}, {0, 0, -1}, *hit);
    CHECK(is_finite(y.dp_du));
    for (const Vec3f tangent : {y.dp_du, y.dp_dv}) {
      CHECK(length(tangent) > 0);
      CHECK(length(normalize(tangent)) == near(1));
      CHECK(std::fabs(dot(normalize(tangent), y.ng)) < 1e-5f);
    }
    CHECK(is_finite(y.uv.x));
  }
}

TEST_CASE("shape: meshes interpolate positions and normals and uv and tangents follow u") {
  const auto scene = lone_shape(smooth_mesh(), kStretch);
  const SceneView view = scene->view();
  const Mesh mesh = smooth_mesh();
  int hits = 0;
  for (std::uint32_t i = 0; i < 500; ++i) {
    const Ray ray = random_ray(i);
    const auto hit = trace_ray(view, ray.origin, ray.direction);
    if (!hit) continue;
    ++hits;
    const auto y = surface_at(view, ray.origin, ray.direction, *hit);
    CHECK(length(y.p - (ray.origin + ray.direction * hit->t)) < 1e-5f);
    const auto& t = mesh.triangles[hit->primitive];
    const float b[3] = {1 - hit->u - hit->v, hit->u, hit->v};
    Vec3f p{}, n{};
    Vec2f uv;
    for (std::size_t k = 0; k < 3; ++k) {
      p = p + mesh.positions[t[k]] * b[k];
      n = n + normalize(kStretch.normal(mesh.normals[t[k]])) * b[k];
      uv = {uv.x + mesh.uvs[t[k]].x * b[k], uv.y + mesh.uvs[t[k]].y * b[k]};
    }
    CHECK(record_difference<Vec3>(y.p, kStretch.point(p)) < 1e-5);
    CHECK(record_difference<Vec3>(y.ns, normalize(n)) < 1e-5);
    CHECK(record_difference<Vec2>(y.uv, uv) < 1e-5);
    CHECK(length(y.ng) == near(1, 1e-5));
    CHECK(dot(y.ng, y.ns) > 0.0f);
    // u increases along the tangent and v is constant.
    const Vec3f e1 = kStretch.vector(mesh.positions[t[1]] - mesh.positions[t[0]]),
                e2 = kStretch.vector(mesh.positions[t[2]] - mesh.positions[t[0]]);
    CHECK(std::fabs(dot(y.dp_du, y.ng)) < 1e-4f * length(y.dp_du));
    const Vec3f n2 = cross(e1, e2);
    const float s1 = dot(cross(y.dp_du, e2), n2) / dot(n2, n2), s2 = dot(cross(e1, y.dp_du), n2) / dot(n2, n2);
    const Vec2f a = mesh.uvs[t[0]], c = mesh.uvs[t[1]], d = mesh.uvs[t[2]];
    CHECK(s1 * (c.x - a.x) + s2 * (d.x - a.x) == near(1, 1e-4));
    CHECK(std::fabs(s1 * (c.y - a.y) + s2 * (d.y - a.y)) < 1e-4f);
    const float r1 = dot(cross(y.dp_dv, e2), n2) / dot(n2, n2), r2 = dot(cross(e1, y.dp_dv), n2) / dot(n2, n2);
    CHECK(std::fabs(r1 * (c.x - a.x) + r2 * (d.x - a.x)) < 1e-4f);
    CHECK(r1 * (c.y - a.y) + r2 * (d.y - a.y) == near(1, 1e-4));
  }
  CHECK(hits > 100);
}

TEST_CASE("shape: meshes without normals are faceted and without uv use barycentric coordinates") {
  Mesh mesh = smooth_mesh();
  mesh.normals.clear();
  mesh.uvs.clear();
  const auto scene = lone_shape(mesh, Transform());
  const auto hit = trace_ray(scene->view(), {0.3f, -0.4f, 5}, {0, 0, -1});
  REQUIRE(hit.has_value());
  const auto y = surface_at(scene->view(), {0.3f, -0.4f, 5}, {0, 0, -1}, *hit);
  CHECK(y.ns == y.ng);
  CHECK(y.uv.x == hit->u);
  CHECK(y.uv.y == hit->v);
  CHECK(length(y.dp_du) > 0.5f);
  CHECK(std::fabs(dot(y.dp_du, y.ng)) < 1e-6f);
}

TEST_CASE("shape: opposing vertex normals and degenerate uv give a valid frame") {
  Mesh mesh = smooth_mesh();
  mesh.normals = {{1, 0, 0.001f}, {-1, 0, 0.001f}, {1, 0, 0.001f}, {-1, 0, 0.001f}};
  mesh.uvs.assign(4, {0.5f, 0.5f});
  const auto scene = lone_shape(mesh, Transform());
  for (std::uint32_t i = 0; i < 200; ++i) {
    const auto u = random4<Scalar>(63, i, 0, 0);
    const Vec3f origin{2 * u.x - 1, 2 * u.y - 1, 5};
    const auto hit = trace_ray(scene->view(), origin, {0, 0, -1});
    REQUIRE(hit.has_value());
    const auto y = surface_at(scene->view(), origin, {0, 0, -1}, *hit);
    CHECK(length(y.ns) == near(1, 1e-5));
    CHECK(length(y.dp_du) > 0.5f);
  }
}

TEST_CASE("shape: SIMD results of mixed kinds equal scalar ones") {
  Description d = empty_scene(4, 4);
  add_shape(d, SphereShape{}, kStretch);
  add_shape(d, DiskShape{}, kPosition);
  add_shape(d, CylinderShape{}, kPosition).flip_normals = true;
  add_shape(d, smooth_mesh(), kPosition);
  add_shape(d, CubeShape{}, kStretch);
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  double worst = 0;
  for (std::uint32_t i = 0; i < 4000; i += kWidth) {
    const auto at = [i](int lane) { return i + static_cast<std::uint32_t>(lane); };
    const auto shape_of = [&](int lane) { return i % 3 == 0 ? 3u : (i / 8 + static_cast<std::uint32_t>(lane)) % 5; };
    const auto hit =
        wide_record<Vec3>([&](int lane) { return kPosition.point(random_direction(64, at(lane)) * 0.9f); });
    const WideFloat u = wide_random(65, i).x * WideFloat(0.5f), v = wide_random(65, i).y * WideFloat(0.5f);
    const auto primitive = [&](int lane) { return static_cast<std::uint32_t>(lane) % 2; };
    const auto wide = surface_point<Wide, true>(view, gather_rows<Wide>(view.geometry.shapes, wide_uints(shape_of)),
                                                wide_uints(primitive), u, v, hit, WideUint(kNone), WideFloat(0.0f));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto one =
          surface_point<Scalar, true>(view, gather_rows<Scalar>(view.geometry.shapes, shape_of(lane)), primitive(lane),
                                      u[lane], v[lane], lane_record(hit, lane), kNone, 0.0f);
      worst = std::max({worst, record_difference<Vec3>(lane_record(wide.p, lane), one.p),
                        record_difference<Vec3>(lane_record(wide.ng, lane), one.ng),
                        record_difference<Vec3>(lane_record(wide.ns, lane), one.ns),
                        record_difference<Vec2>(lane_record(wide.uv, lane), one.uv),
                        record_difference<Vec3>(lane_record(wide.dp_du, lane), one.dp_du) / (1 + length(one.dp_du)),
                        record_difference<Vec3>(lane_record(wide.dp_dv, lane), one.dp_dv) / (1 + length(one.dp_dv)),
                        std::fabs(wide.offset[lane] / double(one.offset) - 1)});
    }
  }
  CHECK(worst < 2e-5);
}

namespace {

/// Distribution of light samples over the uv of the surface below.
ChiSquare target_uv_test(const Scene& scene, const std::function<double(double, double)>& density) {
  const SceneView view = scene.view();
  const auto shape = gather_rows<Scalar>(view.geometry.shapes, 0);
  const auto sample = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const auto s = sample_any_light<Scalar>(view, {0, 0, 0}, u);
    const auto y = surface_point<Scalar, true>(view, shape, 0, 0, 0, s.target, kNone, 0.0f);
    return std::array<double, 2>{y.uv.x, y.uv.y};
  };
  return chi_square_plane(sample, density, {0, 1, 0, 1, 16, 16}, 50000);
}

}  // namespace

TEST_CASE("shape: light sampling of quadrics is uniform by area") {
  const double each = significance_of_each(3);
  const Transform stretch = Transform::translate({1, 2, 3}) * Transform::scale({2, 0.5f, 1.5f});
  CHECK(target_uv_test(*lone_shape(DiskShape{}, stretch), [](double r, double) { return 2 * r; }).p_value > each);
  // Cylinders and ellipsoids are sampled uniformly before the transform.
  CHECK(target_uv_test(*lone_shape(CylinderShape{}, stretch), [](double, double) { return 1.0; }).p_value > each);
  const auto polar = [](double, double v) { return 0.5 * 3.14159265358979 * std::sin(3.14159265358979 * v); };
  CHECK(target_uv_test(*lone_shape(SphereShape{}, stretch), polar).p_value > each);
}

TEST_CASE("shape: light sampling of meshes is uniform by area") {
  Mesh mesh;  // a unit square in the plane z = 0, divided unevenly
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.9f, 0.05f, 0}};
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const auto scene = lone_shape(mesh, Transform());
  const auto sample = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const auto s = sample_any_light<Scalar>(scene->view(), {0.5f, 0.5f, 3}, u);
    return std::array<double, 2>{s.target.x, s.target.y};
  };
  CHECK(chi_square_plane(
            sample, [](double, double) { return 1.0; }, {0, 1, 0, 1, 20, 20}, 100000)
            .p_value > kSignificance);
}

}  // namespace sheaf::test_shape

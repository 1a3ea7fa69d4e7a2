// Ray offsets: rays that start on a surface do not hit it again, at any scale, and no ray leaks out of a closed
// surface.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/surfaces/shape.h"
#include "tests/support/near.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace sheaf::test_ray_offset {

namespace {

constexpr float kScales[] = {1e-3f, 1e-2f, 1, 1e2f, 1e3f, 1e5f};

/// A convex polyhedron around the origin: a faceted sphere of radius 1 by latitude and longitude.
Mesh faceted_ball() {
  constexpr std::uint32_t kRings = 9, kSegments = 13;
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {0, 0, -1}};
  for (std::uint32_t i = 1; i < kRings; ++i)
    for (std::uint32_t j = 0; j < kSegments; ++j) {
      const double theta = 3.14159265 * i / kRings, phi = 2 * 3.14159265 * j / kSegments;
      mesh.positions.push_back({static_cast<float>(std::sin(theta) * std::cos(phi)),
                                static_cast<float>(std::sin(theta) * std::sin(phi)),
                                static_cast<float>(std::cos(theta))});
    }
  const auto vertex = [](std::uint32_t ring, std::uint32_t j) { return 2 + (ring - 1) * kSegments + j % kSegments; };
  for (std::uint32_t j = 0; j < kSegments; ++j) {
    mesh.triangles.push_back({0, vertex(1, j), vertex(1, j + 1)});
    mesh.triangles.push_back({1, vertex(kRings - 1, j + 1), vertex(kRings - 1, j)});
    for (std::uint32_t i = 1; i + 1 < kRings; ++i) {
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  return mesh;
}

/// Flat or convex shapes. A ray that leaves to the outer side never hits the shape again.
enum class Kind { kSphere, kDisk, kCylinder, kRectangle, kCube, kMesh, kTriangle, kCount };
constexpr const char* kKindNames[] = {"sphere", "disk", "cylinder", "rectangle", "cube", "mesh", "triangle"};

void add_kind(Description& d, Kind kind, const Transform& t) {
  switch (kind) {
    case Kind::kSphere:
      add_shape(d, SphereShape{}, t);
      break;
    case Kind::kDisk:
      add_shape(d, DiskShape{}, t);
      break;
    case Kind::kCylinder:
      add_shape(d, CylinderShape{{0, 0, -1}, {0, 0, 1}, 0.8f}, t);
      break;
    case Kind::kRectangle:
      add_shape(d, RectangleShape{}, t);
      break;
    case Kind::kCube:
      add_shape(d, CubeShape{}, t);
      break;
    case Kind::kMesh:
      add_shape(d, faceted_ball(), t);
      break;
    case Kind::kTriangle: {
      Mesh mesh;
      mesh.positions = {{-1, -0.9f, 0.3f}, {1, -0.7f, -0.2f}, {0.1f, 0.9f, 0.1f}};
      mesh.triangles = {{{0, 1, 2}}};
      add_shape(d, mesh, t);
      break;
    }
    case Kind::kCount:
      break;
  }
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  /// Uniform in [a, b).
  float uniform(float a, float b) { return std::uniform_real_distribution<float>(a, b)(engine_); }
  Vec3f direction() {
    for (;;) {
      const Vec3f v{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      const float squared = dot(v, v);
      if (squared < 1 && squared > 1e-4f) return normalize(v);
    }
  }

 private:
  std::mt19937 engine_;
};

RayPacket one_ray(Vec3f origin, Vec3f direction) {
  RayPacket packet;
  packet.set_ray(0, origin, direction);
  return packet;
}

/// Statistics of the rays from the surface.
struct Tally {
  int starts = 0;      ///< points on the surface
  int self_hits = 0;   ///< rays to the outer side that hit something
  int early_hits = 0;  ///< rays through the surface that hit it again at once
};

/// Shoots rays at the shape from around `center`, from a few and from many radii away. From every hit, shoots rays to
/// the incident side, half of them at grazing angles, and to the other side.
Tally shoot(const SceneView& scene, Vec3f center, float radius, int rays) {
  Random random(11);
  Tally tally;
  for (int i = 0; i < rays; ++i) {
    const float distance = radius * (i % 4 == 0 ? 1000.0f : 3.0f);
    const Vec3f origin = center + random.direction() * distance;
    const Vec3f target = center + random.direction() * (0.9f * radius * std::sqrt(random.uniform(0, 1)));
    const Vec3f direction = normalize(target - origin);
    RayPacket hit = one_ray(origin, direction);
    scene.accel->intersect(hit, 1);
    if (hit.shape[0] == kNone) continue;
    const auto shape = gather_rows<Scalar>(scene.geometry.shapes, hit.shape[0]);
    const auto y = surface_point<Scalar>(scene, shape, hit.primitive[0], hit.u[0], hit.v[0],
                                         origin + direction * hit.t_far[0], kNone, 0.0f);
    // Only outer sides of closed shapes; the inside of an open cylinder sees itself.
    const Vec3f outer = dot(y.ng, direction) < 0 ? y.ng : -y.ng;
    if (shape.kind == static_cast<std::uint32_t>(ShapeKind::kCylinder) && dot(y.ng, direction) > 0) continue;
    ++tally.starts;
    for (int j = 0; j < 4; ++j) {
      const auto frame = Frame<Scalar>::from_normal(outer);
      const float z = j < 2 ? random.uniform(0, 1) : std::pow(10.0f, random.uniform(-4, -1));
      const float phi = random.uniform(0, 2 * kPi), r = std::sqrt(1 - z * z);
      const Vec3f away = normalize(frame.to_world({r * std::cos(phi), r * std::sin(phi), z}));
      RayPacket out = one_ray(offset_origin<Scalar>(y.p, y.ng, y.offset, away), away);
      scene.accel->occluded(out, 1);
      tally.self_hits += out.t_far[0] < 0;
      if (z < 0.2f) continue;
      const Vec3f through = normalize(frame.to_world({r * std::cos(phi), r * std::sin(phi), -z}));
      RayPacket in = one_ray(offset_origin<Scalar>(y.p, y.ng, y.offset, through), through);
      scene.accel->intersect(in, 1);
      const bool near = in.shape[0] != kNone && in.t_far[0] < 1e-3f * radius;
      tally.early_hits += near && dot(Vec3f{in.normal_x[0], in.normal_y[0], in.normal_z[0]}, y.ng) >
                                      0.999f * length(Vec3f{in.normal_x[0], in.normal_y[0], in.normal_z[0]});
    }
  }
  return tally;
}

/// A closed room around the camera with a radius of `scale` units, `away` from the origin along the diagonal.
Description closed_room(bool box, float scale, float away) {
  Description d = empty_scene(32, 32);
  d.sampler.sample_count = 32;
  const Vec3f center{away, -away, 0.5f * away};
  look_at(d, center, center + Vec3f{0.7f, 0.2f, 0.4f} * scale);
  const Transform t =
      Transform::translate(center) * Transform::rotate({1, 2, 3}, 25) * Transform::scale({scale, scale, scale});
  if (box) {
    add_shape(d, CubeShape{}, t);
  } else {
    add_shape(d, SphereShape{}, t);
  }
  d.shapes.back().flip_normals = true;
  d.shapes.back().material = add_diffuse(d, 0.5f);
  return d;
}

constexpr std::uint64_t kPaths = 32 * 32 * 32;
constexpr int kDepth = 6;

/// Number of paths in a closed room that end early: leaked, absorbed by a back side, or dropped.
std::uint64_t lost_paths(Description d) {
  d.integrator.max_depth = kDepth;
  d.integrator.rr_depth = kDepth;
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  const RenderResult result = render(*compile_scene(d), {});
  CHECK(result.report.stats.dropped.rays == 0);
  CHECK(result.report.stats.dropped.samples == 0);
  CHECK(result.report.stats.rays.camera == kPaths);
  return kPaths * (kDepth - 1) - result.report.stats.rays.scatter;
}

MeanVariance pixel_statistics(const Description& d) {
  const Image image = render(*compile_scene(d), {}).film.to_image();
  MeanVariance statistics;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) statistics.add(image.at(x, y, 0));
  return statistics;
}

}  // namespace

TEST_CASE("a ray that leaves a convex shape does not hit it again") {
  for (int kind = 0; kind < static_cast<int>(Kind::kCount); ++kind)
    for (const float scale : kScales)
      for (const float away : {0.0f, 10.0f, 1000.0f}) {
        CAPTURE(kKindNames[kind]);
        CAPTURE(scale);
        CAPTURE(away);
        const Vec3f center{away * scale, -0.7f * away * scale, 0.3f * away * scale};
        Description d = empty_scene(1, 1);
        add_kind(d, static_cast<Kind>(kind),
                 Transform::translate(center) * Transform::rotate({3, 1, 2}, 50) *
                     Transform::scale({scale, 0.8f * scale, 0.9f * scale}));
        const auto scene = compile_scene(d);
        const Tally tally = shoot(scene->view(), center, scale, 1500);
        CHECK(tally.starts > 200);
        CHECK(tally.self_hits == 0);
        CHECK(tally.early_hits == 0);
      }
}

TEST_CASE("the offset is small against the shape") {
  for (const float scale : kScales) {
    CAPTURE(scale);
    Description d = empty_scene(1, 1);
    add_shape(d, SphereShape{}, Transform::scale({scale, scale, scale}));
    add_shape(d, CubeShape{}, Transform::translate({4 * scale, 0, 0}) * Transform::scale({scale, scale, scale}));
    const auto scene = compile_scene(d);
    const SceneView view = scene->view();
    for (std::uint32_t i = 0; i < 2; ++i) {
      const auto shape = gather_rows<Scalar>(view.geometry.shapes, i);
      const auto y = surface_point<Scalar>(view, shape, 0, 0.3f, 0.3f, Vec3f{scale, 0, 0}, kNone, 0.0f);
      CHECK(y.offset > 0);
      CHECK(y.offset < 1e-5f * scale);
    }
  }
}

TEST_CASE("no path escapes from a closed room of any size") {
  for (const bool box : {false, true})
    for (const float scale : kScales) {
      CAPTURE(box);
      CAPTURE(scale);
      CHECK(lost_paths(closed_room(box, scale, 0)) == 0);
    }
}

TEST_CASE("few paths escape from a closed room far from the origin") {
  // A path may leak where it hits an edge within rounding: the probability is about the offset over the room's size.
  for (const bool box : {false, true})
    for (const float away : {10.0f, 1000.0f}) {
      CAPTURE(box);
      CAPTURE(away);
      const double edge_fraction = box ? 3 * 8 * 6e-8 * away * 4 : 0;
      const double allowed = kPaths * (kDepth - 1) * edge_fraction;
      CHECK(static_cast<double>(lost_paths(closed_room(box, 1, away))) <= allowed + 4 * std::sqrt(allowed));
    }
}

TEST_CASE("no light from outside enters a closed room" * doctest::test_suite("slow")) {
  for (const bool box : {false, true})
    for (const float scale : {1e-3f, 1.0f, 1e5f})
      for (const LightStrategy strategy : {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly}) {
        CAPTURE(box);
        CAPTURE(scale);
        Description d = closed_room(box, scale, 0);
        d.integrator.strategy = strategy;
        add_constant_light(d, 1);
        add_area_light_sphere(d, Vec3f{3, 3, 3} * scale, scale, 5);
        const MeanVariance statistics = pixel_statistics(d);
        CHECK(statistics.mean() == 0);
      }
}

TEST_CASE("a closed emissive room has equal radiance at every scale" * doctest::test_suite("slow")) {
  const double level = significance_of_each(2 * 6 * 2);
  for (const bool box : {false, true})
    for (const float scale : kScales)
      for (const LightStrategy strategy : {LightStrategy::kMis, LightStrategy::kLightOnly}) {
        CAPTURE(box);
        CAPTURE(scale);
        Description d = closed_room(box, scale, 0);
        d.integrator.strategy = strategy;
        d.integrator.max_depth = 4;
        emit(d.shapes.back(), 1);
        const MeanVariance statistics = pixel_statistics(d);
        const double expected = 1.875, distance = statistics.mean() - expected;
        INFO("mean " << statistics.mean());
        if (std::fabs(distance) > 1e-4) CHECK(statistics.p_value(expected + std::copysign(1e-4, distance)) >= level);
      }
}

TEST_CASE("a sphere in an environment reflects light once at every scale and position") {
  for (const float scale : kScales)
    for (const float away : {0.0f, 1000.0f}) {
      CAPTURE(scale);
      CAPTURE(away);
      const Vec3f center{away * scale, 0, -away * scale};
      Description d = empty_scene(16, 16);
      d.sampler.sample_count = 32;
      d.integrator.strategy = LightStrategy::kBsdfOnly;
      look_at(d, center + Vec3f{3, 1, 2} * scale, center, {0, 1, 0}, 10);
      add_sphere(d, center, scale, add_diffuse(d, 0.5f));
      add_constant_light(d, 1);
      const RenderResult result = render(*compile_scene(d), {});
      CHECK(result.report.stats.rays.scatter == result.report.stats.rays.camera);
      const Image image = result.film.to_image();
      CHECK(image.at(8, 8, 0) == near(0.5));
    }
}

}  // namespace sheaf::test_ray_offset

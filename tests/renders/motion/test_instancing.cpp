// Instances of shape groups: rays hit them as they hit the same shapes placed one by one.
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/instancing_testing.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_instancing {

namespace {

struct Ray {
  Vec3f origin, direction;
};
/// A ray from outside the image of a sphere of radius 3 under `to_world` to a point in that image.
Ray ray_towards(const Transform& to_world, std::uint32_t i) {
  const Vec3f origin = to_world.point(random_direction(71, i) * 8.0f),
              target = to_world.point(random_direction(72, i) * 2.2f);
  return {origin, normalize(target - origin)};
}

double distance(Vec3f a, Vec3f b) { return length(a - b); }

std::string message_of(const Description& d) {
  try {
    compile_scene(d);
  } catch (const SceneError& error) { return error.what(); }
  return {};
}

}  // namespace

TEST_CASE("instancing: rays hit instances as they hit individually placed shapes") {
  for (const NamedTransform& placement : kPlacements) {
    CAPTURE(placement.name);
    Description instanced = empty_scene(1, 1), copied = empty_scene(1, 1);
    const std::vector<ShapeDescription> shapes = every_kind({});
    add_instance(instanced, add_group(instanced, shapes), placement.to_world);
    add_copies(copied, shapes, placement.to_world);
    Description unplaced = empty_scene(1, 1);
    unplaced.shapes = shapes;
    const auto scene = compile_scene(instanced), reference = compile_scene(copied), own = compile_scene(unplaced);
    int hits = 0, others = 0, seen[8] = {};
    double worst_t = 0, worst_p = 0, worst_ng = 0, worst_ns = 0, worst_uv = 0, worst_du = 0, worst_dv = 0;
    for (std::uint32_t i = 0; i < 6000; ++i) {
      const Ray ray = ray_towards(placement.to_world, i);
      const auto a = trace_ray(scene->view(), ray.origin, ray.direction);
      const auto b = trace_ray(reference->view(), ray.origin, ray.direction);
      if (a.has_value() != b.has_value() || (a && a->shape != b->shape)) {
        ++others;
        continue;
      }
      if (!a) continue;
      ++hits;
      ++seen[a->shape];
      CHECK(a->instance == 0);
      CHECK(b->instance == kNone);
      const auto x = surface_at(scene->view(), ray.origin, ray.direction, *a);
      const auto y = surface_at(reference->view(), ray.origin, ray.direction, *b);
      worst_t = std::max(worst_t, std::fabs(a->t - double(b->t)));
      worst_p = std::max(worst_p, distance(x.p, y.p));
      worst_ng = std::max(worst_ng, distance(x.ng, y.ng));
      // Vertex normals are interpolated in the space of the group.
      const Vec3f hit_point = placement.to_world.inverse().point(x.p);
      const auto z = surface_point<Scalar>(own->view(), gather_rows<Scalar>(own->view().geometry.shapes, a->shape),
                                           a->primitive, a->u, a->v, hit_point, kNone, 0.0f);
      worst_ns = std::max(worst_ns, distance(x.ns, normalize(placement.to_world.normal(z.ns))));
      const double difference = std::fabs(x.uv.x - double(y.uv.x));
      worst_uv =
          std::max({worst_uv, std::min(difference, std::fabs(1 - difference)), std::fabs(x.uv.y - double(y.uv.y))});
      worst_du = std::max(worst_du, distance(x.dp_du, y.dp_du) / length(y.dp_du));
      worst_dv = std::max(worst_dv, distance(x.dp_dv, y.dp_dv) / length(y.dp_dv));
    }
    CHECK(hits > 1500);
    for (const int count : seen) CHECK(count > 30);
    CHECK(others < 12);
    CHECK(worst_t < 1e-4);
    CHECK(worst_p < 1e-4);
    CHECK(worst_ng < 1e-4);
    CHECK(worst_ns < 1e-4);
    CHECK(worst_uv < 2e-4);
    CHECK(worst_du < 5e-3);
    CHECK(worst_dv < 5e-3);
  }
}

TEST_CASE("instancing: normals under mirroring transforms match Mitsuba") {
  Description d = empty_scene(1, 1);
  Description shapes;
  add_shape(shapes, SphereShape{}, Transform());
  add_shape(shapes, RectangleShape{}, Transform::translate({3, 0, 0}));
  add_instance(d, add_group(d, shapes.shapes), Transform::scale({-1, 2, 1}));
  const auto scene = compile_scene(d);
  const auto check = [&](Vec3f origin, Vec3f n, Vec3f du, Vec3f dv) {
    const auto hit = trace_ray(scene->view(), origin, {0, 0, 1});
    REQUIRE(hit.has_value());
    const auto y = surface_at(scene->view(), origin, {0, 0, 1}, *hit);
    CHECK(distance(y.ng, n) < 1e-5);
    CHECK(distance(y.ns, n) < 1e-5);
    CHECK(distance(y.dp_du, du) < 1e-4);
    CHECK(distance(y.dp_dv, dv) < 1e-4);
  };
  check({0.3f, 0.2f, -5}, {0.301131f, 0.0501886f, -0.952261f}, {0.628319f, -3.76991f, 0},
        {-2.82743f, -1.88496f, -0.993459f});
  check({-3.2f, 0.1f, -5}, {0, 0, 1}, {-2, 0, 0}, {0, 4, 0});
}

TEST_CASE("instancing: SIMD results of mixed shapes and instances equal scalar ones") {
  Description d = empty_scene(4, 4);
  add_shape(d, SphereShape{}, Transform());
  add_shape(d, smooth_mesh(), Transform());
  const std::uint32_t group = add_group(d, every_kind({}));
  for (const NamedTransform& placement : kPlacements) add_instance(d, group, placement.to_world);
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  REQUIRE(view.geometry.shape_count == 10);
  double worst = 0;
  for (std::uint32_t i = 0; i < 2000; i += kWidth) {
    const auto at = [i](int lane) { return i + static_cast<std::uint32_t>(lane); };
    const auto shape_of = [&](int lane) { return (at(lane) * 7 + i / 64) % 10; };
    const auto instance_of = [&](int lane) { return shape_of(lane) < 2 ? kNone : at(lane) % 8; };
    const auto hit = wide_record<Vec3>([&](int lane) { return random_direction(64, at(lane)) * 2.0f; });
    const WideFloat u = wide_random(65, i).x * WideFloat(0.5f), v = wide_random(65, i).y * WideFloat(0.5f);
    const auto wide = surface_point<Wide, true>(view, gather_rows<Wide>(view.geometry.shapes, wide_uints(shape_of)),
                                                WideUint(1u), u, v, hit, wide_uints(instance_of), WideFloat(0.0f));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto one = surface_point<Scalar, true>(view, gather_rows<Scalar>(view.geometry.shapes, shape_of(lane)), 1u,
                                                   u[lane], v[lane], lane_record(hit, lane), instance_of(lane), 0.0f);
      const auto relative = [&](const Vec3<Wide>& a, Vec3f b) {
        return distance(lane_record(a, lane), b) / (1 + length(b));
      };
      worst = std::max({worst, relative(wide.p, one.p), relative(wide.ng, one.ng), relative(wide.ns, one.ns),
                        relative(wide.dp_du, one.dp_du), relative(wide.dp_dv, one.dp_dv),
                        std::fabs(wide.offset[lane] / double(one.offset) - 1)});
    }
  }
  CHECK(worst < 3e-5);
}

TEST_CASE("instancing: each of thousands of instances is hit at its position") {
  constexpr std::uint32_t kSide = 14, kCount = kSide * kSide * kSide;
  Description d = empty_scene(1, 1);
  add_sphere(d, {-10, -10, -10}, 1);
  Description one, two;
  add_sphere(one, {0, 0, 0}, 0.3f);
  add_sphere(two, {0, 0, 0}, 0.2f);
  add_shape(two, CubeShape{}, Transform::translate({0, 0, 9999}));
  add_group(d, one.shapes);
  add_group(d, two.shapes);
  const auto center = [](std::uint32_t i) {
    const std::uint32_t x = i % kSide, y = i / kSide % kSide, z = i / (kSide * kSide);
    return Vec3f{float(x), float(y), float(z)};
  };
  for (std::uint32_t i = 0; i < kCount; ++i) add_instance(d, i % 3 == 0 ? 1 : 0, Transform::translate(center(i)));
  const auto scene = compile_scene(d);
  CHECK(scene->info().instances == kCount);
  CHECK(scene->info().groups == 2);
  CHECK(scene->info().shapes == 4);
  CHECK(scene->info().instanced_triangles == 12 * ((kCount + 2) / 3));
  for (std::uint32_t first = 0; first < kCount; first += kPacketWidth) {
    RayPacket packet;
    const int count = static_cast<int>(std::min<std::uint32_t>(kPacketWidth, kCount - first));
    for (int i = 0; i < count; ++i) {
      packet.set_ray(i, center(first + static_cast<std::uint32_t>(i)) - Vec3f{0, 0, 0.5f}, {0, 0, 1});
    }
    scene->view().accel->intersect(packet, count);
    for (int i = 0; i < count; ++i) {
      const std::uint32_t index = first + static_cast<std::uint32_t>(i);
      CHECK(packet.instance[i] == index);
      CHECK(packet.shape[i] == (index % 3 == 0 ? 2 : 1));
      CHECK(packet.t_far[i] == near(index % 3 == 0 ? 0.3 : 0.2));
      CHECK(packet.normal_z[i] < 0);
    }
  }
  const auto plain = trace_ray(scene->view(), {-10, -10, -15}, {0, 0, 1});
  REQUIRE(plain.has_value());
  CHECK(plain->shape == 0);
  CHECK(plain->instance == kNone);
}

TEST_CASE("instancing: bounds include instances and empty groups are accepted and invalid ones rejected") {
  Description d = empty_scene(1, 1), ball, flat;
  add_sphere(ball, {1, 0, 0}, 1);
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  add_shape(flat, line, Transform());
  const std::uint32_t nothing = add_group(d, flat.shapes), balls = add_group(d, ball.shapes);
  add_group(d, {});
  add_instance(d, nothing, Transform());
  add_instance(d, balls, Transform::translate({0, 5, 0}) * Transform::scale({-2, 1, 1}));
  const auto scene = compile_scene(d);
  const SceneInfo info = scene->info();
  CHECK(info.instances == 1);
  CHECK(info.groups == 1);
  CHECK(scene->warnings().size() == 2);
  CHECK(distance(info.bounds_min.rounded(), {-4, 4, -1}) < 1e-4);
  CHECK(distance(info.bounds_max.rounded(), {0, 6, 1}) < 1e-4);
  CHECK(trace_ray(scene->view(), {-2, 5, -5}, {0, 0, 1}).has_value());
  CHECK_FALSE(trace_ray(scene->view(), {1, 0, -5}, {0, 0, 1}).has_value());

  Description glowing = d;
  glowing.groups[balls].shapes[0].radiance = SpectrumDescription::constant(1);
  CHECK(compile_scene(glowing)->info().lights == 1);
  Description singular = d;
  singular.instances[1].to_world[0] = 0;
  CHECK(test::contains(message_of(singular), "singular"));
  Description far = d;
  far.groups[balls].shapes[0].to_world = Transform::translate({1e12f, 0, 0});
  far.instances[1].to_world[0] = 1e8f;
  const auto without = compile_scene(far);
  CHECK(without->info().instances == 0);
  CHECK(without->warnings().size() == 3);
}

}  // namespace sheaf::test_instancing

// Instanced lights: agreement with repeated shapes and of all strategies, shadow rays, and SIMD results among other
// lights.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/tables/instance.h"
#include "tests/scene/lights/floor_lighting.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace sheaf::test_instanced_lights {

using namespace floor_lighting;

namespace {

/// Emissive shapes of all kinds, and one that does not emit.
std::vector<ShapeDescription> emissive_shapes(Description& d) {
  const MaterialId black = add_diffuse(d, 0);
  const Transform ball = Transform::translate({0.4f, 0, 0}) * Transform::scale({0.2f, 0.2f, 0.2f});
  const Transform card = Transform::translate({0, 0.6f, 0}) * Transform::scale({0.3f, 0.2f, 1});
  const Transform plate = Transform::translate({0, -0.5f, 0}) * Transform::scale({0.3f, 0.3f, 1});
  emit(add_shape(d, SphereShape{}, ball, black), 3);
  add_shape(d, CubeShape{}, Transform::scale({0.05f, 0.05f, 0.05f}), black);
  emit(add_shape(d, RectangleShape{}, card, black), 5);
  emit(add_shape(d, CylinderShape{{-0.5f, 0, 0}, {-0.4f, 0.3f, 0.1f}, 0.1f}, Transform(), black), 2);
  add_shape(d, DiskShape{}, plate, black).radiance = add_checkerboard(d, {8, 1, 1}, {2, 3, 1});
  std::vector<ShapeDescription> shapes(d.shapes.end() - 5, d.shapes.end());
  d.shapes.resize(d.shapes.size() - 5);
  return shapes;
}

/// The matrices of the instances. The last two mirror.
const Transform kTransforms[] = {
    Transform::translate({-1, 0.3f, 1.5f}) * Transform::rotate({1, 0, 0}, 170),
    Transform::translate({1, 0, 1.2f}) * Transform::rotate({1, 1, 0}, 150) * Transform::scale({-1.2f, 0.7f, 0.9f}),
    Transform::translate({0, 1.2f, 2}) * Transform::rotate({0.2f, 1, 0}, 190) * Transform::scale({-0.8f, 0.8f, 0.8f})};

/// A floor under instances of a group of emissive shapes.
Description instanced_scene() {
  Description d = floor_scene();
  add_area_light_sphere(d, {0, -2.5f, 0.5f}, 0.1f, 50);  // so that instances are not the first lights
  ShapeGroup group;
  group.shapes = emissive_shapes(d);
  d.groups.push_back(group);
  for (const Transform& transform : kTransforms) {
    InstanceDescription instance;
    for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = transform.matrix().m[i / 4][i % 4];
    d.instances.push_back(instance);
  }
  return d;
}

/// The same with copies of the shapes instead of instances.
Description repeated_scene() {
  Description d = floor_scene();
  add_area_light_sphere(d, {0, -2.5f, 0.5f}, 0.1f, 50);  // so that instances are not the first lights
  const std::vector<ShapeDescription> shapes = emissive_shapes(d);
  for (const Transform& transform : kTransforms)
    for (ShapeDescription shape : shapes) {
      shape.to_world = transform * shape.to_world;
      d.shapes.push_back(shape);
    }
  return d;
}

}  // namespace

TEST_CASE("lights: instances emit like shapes in their place") {
  const auto instanced = compile_scene(instanced_scene()), repeated = compile_scene(repeated_scene());
  const SceneView a = instanced->view(), b = repeated->view();
  REQUIRE(a.lights.count == 13);
  REQUIRE(b.lights.count == 13);
  for (std::uint32_t i = 0; i < 13; ++i) {
    CAPTURE(i);
    const LightRow &x = a.lights.rows[i], &y = b.lights.rows[i];
    CHECK(x.kind == y.kind);
    CHECK(a.lights.powers[i].x == near(b.lights.powers[i].x, 1e-4));
    CHECK(a.lights.powers[i].y == near(b.lights.powers[i].y, 1e-4));
    if (!x.is(kLightKind<MeshLightKind>) && !x.is(kLightKind<RectangleLightKind>)) continue;
    const auto m = x.data<MeshLightData>(), n = y.data<MeshLightData>();
    CHECK(m.area == near(n.area, 1e-4));
    for (std::uint32_t t = 0; t < m.triangle_count; ++t) {
      // The vertex order of mirrored shapes may differ; the plane may not.
      const auto &p = a.lights.triangles[m.first_triangle + t], &q = b.lights.triangles[n.first_triangle + t];
      CHECK(record_difference<Vec3>(p.normal, q.normal) < 1e-4);
    }
  }
}

TEST_CASE("lights: all strategies agree on emissive instances") {
  const Description d = instanced_scene(), e = repeated_scene();
  const double mean = agreed(d);
  const Result other = rendered(e);
  CHECK(std::fabs(mean - other.mean) < 4.5 * std::sqrt(2.0) * other.error);
  Description seen = d, expected = e;
  for (Description* scene : {&seen, &expected}) {
    scene->integrator.max_depth = 1;
    look_at(*scene, {0, 0, 0.1f}, {0, 0.3f, 2}, {0, 1, 0}, 110);
  }
  const Image x = render(*compile_scene(seen), {}).film.to_image();
  const Image y = render(*compile_scene(expected), {}).film.to_image();
  for (int k = 0; k < 3; ++k) {
    double sum = 0, difference = 0;
    for (int i = 0; i < 24 * 24; ++i) {
      sum += y.at(i % 24, i / 24, k);
      difference += std::fabs(y.at(i % 24, i / 24, k) - x.at(i % 24, i / 24, k));
    }
    CHECK(sum > 0);
    CHECK(difference < 1e-3 * sum);
  }
}

TEST_CASE("lights: no shadow ray to an emissive instance is blocked by that instance") {
  const auto scene = compile_scene(instanced_scene());
  const SceneView view = scene->view();
  int valid = 0, blocked = 0;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto u = random4<Scalar>(11, i, 0, 0);
    const auto s = sample_any_light<Scalar>(view, {0, 0, 0.01f}, u);
    if (!s.valid) continue;
    ++valid;
    RayPacket packet{};
    for (int lane = 0; lane < kPacketWidth; ++lane) {
      packet.set_ray(lane, {0, 0, 0.01f}, s.target - Vec3f{0, 0, 0.01f}, 1);
      packet.shape[lane] = kNone;
    }
    view.accel->intersect(packet, 1);
    // A hit just before the target would be the light itself.
    if (packet.shape[0] != kNone && packet.t_far[0] > 0.999f) ++blocked;
  }
  CHECK(valid > 3000);
  CHECK(blocked == 0);
}

TEST_CASE("lights: SIMD results of mixed lights equal scalar ones") {
  Description d = instanced_scene();
  const TextureId one = add_checkerboard(d, {1, 2, 3}, {4, 5, 6}), two = add_checkerboard(d, {7, 1, 2}, {3, 4, 5});
  add_rectangle(d, kTransforms[0] * Transform::translate({2, 0, 0})).radiance = one;
  add_rectangle(d, kTransforms[2] * Transform::translate({-2, 0, 0})).radiance = two;
  SpotLightDescription spot;
  spot.to_world = Transform::translate({0, 0, 2}) * Transform::rotate({1, 0, 0}, 180);
  spot.cutoff_angle = 60;
  spot.intensity = SpectrumDescription::constant(3);
  d.lights.push_back({spot, {}});
  spot.texture = two;
  d.lights.push_back({spot, {}});
  spot.texture.reset();
  spot.falloff = SpotLightDescription::Falloff::kSmooth;
  d.lights.push_back({spot, {}});
  ProjectorDescription projector;
  projector.to_world = spot.to_world;
  projector.irradiance = one;
  d.lights.push_back({projector, {}});
  d.lights.push_back({DirectionalLightDescription{}, {}});
  add_point_light(d, {0, 1, 1}, 3);
  add_constant_light(d, 0.1f);
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  std::vector<int> seen(view.lights.count);
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto u = [i](int lane) { return random4<Scalar>(12, i, static_cast<std::uint32_t>(lane), 0); };
    const auto light_of = [&](int lane) { return (i * 7 + static_cast<std::uint32_t>(lane)) % view.lights.count; };
    const auto from = [&](int lane) { return Vec3f{u(lane).x - 0.5f, u(lane).w - 0.5f, 0.3f * u(lane).y}; };
    const auto wide_u = [&](auto member) { return wide_floats([&](int k) { return u(k).*member; }); };
    using U4 = Random4<Scalar>;
    const Random4<Wide> random{wide_u(&U4::x), wide_u(&U4::y), wide_u(&U4::z), wide_u(&U4::w)};
    const auto wide_from = [&](auto member) { return wide_floats([&](int k) { return from(k).*member; }); };
    const Vec3<Wide> origin{wide_from(&Vec3f::x), wide_from(&Vec3f::y), wide_from(&Vec3f::z)};
    const auto lights = load_lights<Wide>(view, wide_uints([&](int k) { return light_of(k); }));
    const auto wide = sample_given_light<Wide>(view, {origin, {}}, lights, random);
    for (int k = 0; k < kWidth; ++k) {
      const auto s = sample_given_light<Scalar>(view, {from(k), {}}, load_lights<Scalar>(view, light_of(k)), u(k));
      CAPTURE(light_of(k));
      if (lane_of(wide.valid, k) != s.valid) continue;  // rounding at an edge, counted below
      if (!s.valid) continue;
      ++seen[light_of(k)];
      CHECK(lane_of(wide.delta, k) == s.delta);
      CHECK(difference(wide.target.x[k], s.target.x) < 1e-4);
      CHECK(difference(wide.target.z[k], s.target.z) < 1e-4);
      CHECK(difference(wide.pdf_solid_angle[k], s.pdf_solid_angle) < 1e-3);
      // Checkerboards have sharp edges.
      if (difference(wide.radiance.c1[k], s.radiance.c1) > 1e-3) CHECK(view.lights.rows[light_of(k)].texture != kNone);
    }
  }
  for (std::uint32_t i = 0; i < view.lights.count; ++i) {
    CAPTURE(i);
    CHECK(seen[i] > 20);
  }
}

}  // namespace sheaf::test_instanced_lights

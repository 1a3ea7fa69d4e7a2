// Lights with a direction, with textures and in instances: closed forms, power, all strategies alike, and registers
// against single values.
#include "kernels/passes/render.h"
#include "scene/compile/compile.h"
#include "scene/compile/light.h"
#include "scene/tables/instance.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/light_testing.h"
#include "tests/support/records_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <utility>

namespace sheaf::test_lights {

namespace {

constexpr double kPiD = std::numbers::pi;
constexpr double kDegrees = kPiD / 180;

template <class Model> std::unique_ptr<Scene> lone(Model model) {
  Description d = empty_scene(4, 4);
  d.lights.push_back({std::move(model), {"scene.xml", 9}});
  return compile_scene(d);
}

LightSample<Scalar> sample_at(const SceneView& scene, Vec3f from) {
  return sample_any_light<Scalar>(scene, from, {0.5f, 0.5f, 0.5f, 0.5f});
}

TextureId add_board(Description& d, Vec3f first, Vec3f second) {
  CheckerboardDescription board{SpectrumDescription{SpectrumDescription::Rgb{first}},
                                SpectrumDescription{SpectrumDescription::Rgb{second}}};
  d.textures.push_back({board, {}, {}, {}});
  d.textures.back().to_uv = {1, 0, 0, 0, 1, 0};
  return static_cast<TextureId>(d.textures.size() - 1);
}

/// Flux through the plane z = 1, of what a lone light at the origin sends to squares of [-half, half]^2.
double flux(const SceneView& scene, double half) {
  constexpr int kSide = 800;
  double sum = 0;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const double x = half * (2 * (i + 0.5) / kSide - 1), y = half * (2 * (j + 0.5) / kSide - 1);
      const Vec3f p{static_cast<float>(x), static_cast<float>(y), 1};
      const auto s = sample_at(scene, p);
      if (s.valid) sum += double(s.radiance.c0) * std::fabs(s.direction.z);
    }
  return sum * 4 * half * half / (double(kSide) * kSide);
}

struct Result {
  double mean, error;
};
Result rendered(const Description& d, int channel = 0) {
  const Image image = render(*compile_scene(d), {}).film.to_image();
  MeanVariance statistics;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) statistics.add(image.at(x, y, channel));
  return {statistics.mean(), std::sqrt(statistics.variance() / static_cast<double>(image.pixel_count()))};
}

/// A white floor at the origin, of which the camera sees one point.
Description floor_scene() {
  Description d = empty_scene(24, 24);
  d.sampler.sample_count = 256;
  d.integrator.max_depth = 2;
  look_at(d, {2.8f, 0.1f, 0.3f}, {0, 0, 0}, {0, 0, 1}, 0.01f);
  add_rectangle(d, Transform::scale({3, 3, 3}), add_diffuse(d, 0.5f));
  return d;
}

/// What all strategies agree on, within their errors.
double agreed(Description d, int channel = 0) {
  Result results[3];
  for (int i = 0; i < 3; ++i) {
    constexpr LightStrategy kAll[] = {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly};
    d.integrator.strategy = kAll[i];
    results[i] = rendered(d, channel);
    CAPTURE(i);
    CAPTURE(results[i].mean);
    CAPTURE(results[0].mean);
    CHECK(results[i].mean > 0);
    CHECK(results[i].error < 0.02 * results[i].mean);
    const double sigma = std::hypot(results[i].error, results[0].error);
    CHECK(std::fabs(results[i].mean - results[0].mean) <= 4.5 * sigma + 1e-5 * results[0].mean);
  }
  return results[0].mean;
}

}  // namespace

TEST_CASE("lights: a spot falls off linearly in the angle") {
  SpotLightDescription spot;
  spot.to_world = Transform::translate({1, 2, 3}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({2, 2, 2});
  spot.intensity = SpectrumDescription::constant(8);
  spot.cutoff_angle = 40;
  spot.beam_width = 10;
  const auto scene = lone(spot);
  const auto at = [&](double degrees) {
    const auto s = sample_at(scene->view(), {1 + 2 * static_cast<float>(std::cos(degrees * kDegrees)), 2,
                                             3 + 2 * static_cast<float>(std::sin(degrees * kDegrees))});
    CHECK((s.delta && s.pdf_solid_angle == 1.0f));
    return s.valid ? double(s.radiance.c0) : 0.0;
  };
  CHECK(at(0) == doctest::Approx(2));
  CHECK(at(9.9) == doctest::Approx(2));
  CHECK(at(25) == doctest::Approx(1));
  CHECK(at(37) == doctest::Approx(0.2));
  CHECK(at(40.1) == 0);
  CHECK(at(150) == 0);
}

TEST_CASE("lights: a smooth spot is half way in the middle of the cosines") {
  SpotLightDescription spot;
  spot.falloff = SpotLightDescription::Falloff::kSmooth;
  spot.cutoff_angle = 60;
  spot.beam_width = 20;
  const auto scene = lone(spot);
  const double middle = 0.5 * (std::cos(60 * kDegrees) + std::cos(20 * kDegrees));
  const auto at = [&](double cosine) {
    const auto sine = static_cast<float>(std::sqrt(1 - cosine * cosine));
    const auto s = sample_at(scene->view(), {sine, 0, static_cast<float>(cosine)});
    return s.valid ? double(s.radiance.c0) : 0.0;
  };
  CHECK(at(middle) == doctest::Approx(0.5));
  CHECK(at(std::cos(19 * kDegrees)) == doctest::Approx(1));
  CHECK(at(std::cos(61 * kDegrees)) == 0);
  const double quarter = std::cos(60 * kDegrees) + 0.25 * (std::cos(20 * kDegrees) - std::cos(60 * kDegrees));
  CHECK(at(quarter) == doctest::Approx(0.15625));
}

TEST_CASE("lights: the flux of spots and projectors is their power") {
  SUBCASE("linear") {
    SpotLightDescription spot;
    spot.intensity = SpectrumDescription::constant(3);
    spot.cutoff_angle = 50;
    spot.beam_width = 20;
    const auto scene = lone(spot);
    const double c = 50 * kDegrees, b = 20 * kDegrees;
    const double expected = 2 * kPiD * 3 * (1 - (std::sin(c) - std::sin(b)) / (c - b));
    CHECK(flux(scene->view(), 1.3) == doctest::Approx(expected).epsilon(1e-3));
    CHECK(scene->view().lights.powers[0].x == doctest::Approx(expected).epsilon(1e-3));
  }
  SUBCASE("smooth") {
    SpotLightDescription spot;
    spot.falloff = SpotLightDescription::Falloff::kSmooth;
    spot.cutoff_angle = 50;
    spot.beam_width = 20;
    const auto scene = lone(spot);
    const double expected = kPiD * (2 - std::cos(20 * kDegrees) - std::cos(50 * kDegrees));
    CHECK(flux(scene->view(), 1.3) == doctest::Approx(expected).epsilon(1e-3));
    CHECK(scene->view().lights.powers[0].x == doctest::Approx(expected).epsilon(1e-3));
  }
  SUBCASE("textured") {
    Description d = empty_scene(4, 4);
    SpotLightDescription spot;
    spot.cutoff_angle = 45;
    spot.beam_width = 45;
    spot.texture = add_board(d, {2, 2, 2}, {0, 0, 0});
    d.lights.push_back({spot, {}});
    const auto scene = compile_scene(d);
    const double expected = 2 * kPiD * (1 - std::cos(45 * kDegrees));  // half of the cone at twice the intensity
    CHECK(flux(scene->view(), 1.1) == doctest::Approx(expected).epsilon(3e-3));
    CHECK(scene->view().lights.powers[0].x == doctest::Approx(expected).epsilon(1e-2));
    CHECK(sample_at(scene->view(), {-0.1f, -0.1f, 1}).radiance.c0 > 1);
    CHECK(sample_at(scene->view(), {0.1f, -0.1f, 1}).radiance.c0 == 0);
  }
  SUBCASE("projector") {
    ProjectorDescription projector;
    projector.irradiance = SpectrumDescription::constant(0.5f);
    projector.scale = 3;
    projector.fov = 60;
    const auto scene = lone(projector);
    const double expected = kPiD * 1.5 * 4 * std::tan(30 * kDegrees) * std::tan(30 * kDegrees);
    CHECK(flux(scene->view(), std::tan(30 * kDegrees) * 1.0001) == doctest::Approx(expected).epsilon(2e-3));
    CHECK(scene->view().lights.powers[0].x == doctest::Approx(expected).epsilon(1e-4));
    CHECK_FALSE(sample_at(scene->view(), {0, 0.6f, 1}).valid);
    CHECK_FALSE(sample_at(scene->view(), {0, 0, -1}).valid);
  }
}

TEST_CASE("lights: parallel light") {
  Description d = floor_scene();
  DirectionalLightDescription light;
  light.direction = {0, 3, -4};
  light.irradiance = SpectrumDescription::constant(2);
  d.lights.push_back({light, {}});
  const auto scene = compile_scene(d);
  const auto s = sample_at(scene->view(), {0.1f, 0.2f, 0});
  CHECK((s.valid && s.delta && s.pdf_solid_angle == 1.0f));
  CHECK(length(s.direction - Vec3f{0, -0.6f, 0.8f}) < 1e-6f);
  CHECK(length(s.target - scene->view().center) > scene->view().radius);
  CHECK(rendered(d).mean == doctest::Approx(0.5 / kPiD * 2 * 0.8).epsilon(1e-5));
  // BSDF sampling alone cannot find it.
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  CHECK(rendered(d).mean == 0);
}

TEST_CASE("lights: a sun and the sky, by every strategy") {
  Description d = floor_scene();
  SunDescription sun;
  sun.up = {0, 0, 1};
  sun.direction = normalize(Vec3f{0.3f, 0.2f, 0.8f});
  sun.radius = 20;
  d.lights.push_back({sun, {}});
  const auto scene = compile_scene(d);
  const LightRow& row = scene->view().lights.rows[0];
  // Lambert's cosine over a cone above the horizon: pi sin^2 of its half angle times the cosine of its axis.
  const double cosine = double(sun.direction.z), disk = kPiD * std::pow(std::sin(20 * kDegrees), 2);
  CHECK(agreed(d) == doctest::Approx(0.5 / kPiD * double(row.radiance.c0) * disk * cosine).epsilon(0.01));
  SkyDescription sky;
  sky.up = sun.up;
  sky.suns = {sun.direction};
  sky.resolution = 64;
  sky.scale = 1e4f;
  d.lights.push_back({sky, {}});
  agreed(d, 1);
}

TEST_CASE("lights: pictures on lights of every shape, by every strategy" * doctest::test_suite("slow")) {
  Description d = floor_scene();
  const TextureId board = add_board(d, {6, 1, 1}, {2, 3, 1}), other = add_board(d, {1, 5, 1}, {9, 2, 1});
  const Transform down = Transform::translate({0.3f, 0.2f, 1.5f}) * Transform::rotate({1, 0, 0}, 180);
  const MaterialId black = add_diffuse(d, 0);
  const auto light = [&](auto geometry, const Transform& to_world, TextureId texture) -> ShapeDescription& {
    ShapeDescription& shape = add_shape(d, geometry, to_world, black);
    shape.radiance = texture;
    return shape;
  };
  SUBCASE("rectangle") { light(RectangleShape{}, down, board); }
  SUBCASE("mesh without uv") {
    Mesh mesh;
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    light(mesh, down, board);
  }
  SUBCASE("cube") { light(CubeShape{}, down * Transform::scale({0.5f, 0.4f, 0.3f}), board); }
  SUBCASE("disk") { light(DiskShape{}, down * Transform::scale({0.5f, 1, 1}), board); }
  SUBCASE("sphere") { light(SphereShape{}, down * Transform::scale({0.7f, 0.7f, 0.7f}), board); }
  SUBCASE("ellipsoid") { light(SphereShape{}, down * Transform::scale({0.9f, 0.5f, 0.7f}), board); }
  SUBCASE("cylinder") { light(CylinderShape{{0, -0.5f, 0}, {0.2f, 0.5f, 0}, 0.4f}, down, board); }
  SUBCASE("several") {
    light(RectangleShape{}, down, board);
    light(SphereShape{}, Transform::translate({1, -1, 1}) * Transform::scale({0.3f, 0.3f, 0.3f}), other);
    add_area_light_sphere(d, {-1, -1, 1}, 0.3f, 4);
    add_constant_light(d, 0.2f);
  }
  CHECK(agreed(d) > 0);
  CHECK(agreed(d, 1) > 0);
}

TEST_CASE("lights: a picture's mean counts") {
  Description d = floor_scene(), plain = floor_scene();
  const Transform above = Transform::translate({0, 0, 2}) * Transform::rotate({1, 0, 0}, 180);
  // Symmetric under a turn by 90 degrees but for which squares are which: the point below sees the mean of the two.
  add_rectangle(d, above, add_diffuse(d, 0)).radiance = add_board(d, {6, 6, 6}, {2, 2, 2});
  add_area_light_rectangle(plain, above, 4);
  const Result a = rendered(d), b = rendered(plain);
  CHECK(std::fabs(a.mean - b.mean) < 4.5 * std::hypot(a.error, b.error));
  const auto scene = compile_scene(d), other = compile_scene(plain);
  CHECK(scene->view().lights.powers[0].x == doctest::Approx(4 * kPiD * 4).epsilon(5e-3));
  CHECK(other->view().lights.powers[0].x == doctest::Approx(4 * kPiD * 4).epsilon(1e-5));
}

TEST_CASE("lights: a mesh's attribute shines") {
  Description d = floor_scene();
  d.textures.push_back({MeshAttributeDescription{"face_color", 2}, {1, 0, 0, 0, 1, 0}, "", {}});
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.attributes.push_back({"face_color", 3, {4, 0, 1, 0, 2, 1}});
  const Transform above = Transform::translate({0.4f, 0.1f, 1.5f}) * Transform::rotate({1, 0, 0}, 180);
  add_shape(d, mesh, above, add_diffuse(d, 0)).radiance = TextureId{0};
  CHECK(agreed(d) > 0);
  const Vec3f power = compile_scene(d)->view().lights.powers[0];
  CHECK(power.x == doctest::Approx(kPiD * 2 * 8));
  CHECK(power.y == doctest::Approx(kPiD * 2 * 4));
  CHECK(power.z == doctest::Approx(kPiD * 4 * 2));
}

namespace {

/// Shapes of all kinds that emit, and one that doesn't.
std::vector<ShapeDescription> glowing_shapes(Description& d) {
  const MaterialId black = add_diffuse(d, 0);
  const Transform ball = Transform::translate({0.4f, 0, 0}) * Transform::scale({0.2f, 0.2f, 0.2f});
  const Transform card = Transform::translate({0, 0.6f, 0}) * Transform::scale({0.3f, 0.2f, 1});
  const Transform plate = Transform::translate({0, -0.5f, 0}) * Transform::scale({0.3f, 0.3f, 1});
  emit(add_shape(d, SphereShape{}, ball, black), 3);
  add_shape(d, CubeShape{}, Transform::scale({0.05f, 0.05f, 0.05f}), black);
  emit(add_shape(d, RectangleShape{}, card, black), 5);
  emit(add_shape(d, CylinderShape{{-0.5f, 0, 0}, {-0.4f, 0.3f, 0.1f}, 0.1f}, Transform(), black), 2);
  add_shape(d, DiskShape{}, plate, black).radiance = add_board(d, {8, 1, 1}, {2, 3, 1});
  std::vector<ShapeDescription> shapes(d.shapes.end() - 5, d.shapes.end());
  d.shapes.resize(d.shapes.size() - 5);
  return shapes;
}

const Transform kPlaces[] = {
    Transform::translate({-1, 0.3f, 1.5f}) * Transform::rotate({1, 0, 0}, 170),
    Transform::translate({1, 0, 1.2f}) * Transform::rotate({1, 1, 0}, 150) * Transform::scale({-1.2f, 0.7f, 0.9f}),
    Transform::translate({0, 1.2f, 2}) * Transform::rotate({0.2f, 1, 0}, 190) * Transform::scale({-0.8f, 0.8f, 0.8f})};

Description instanced_scene() {
  Description d = floor_scene();
  add_area_light_sphere(d, {0, -2.5f, 0.5f}, 0.1f, 50);  // the instances' lights are not the first
  ShapeGroup group;
  group.shapes = glowing_shapes(d);
  d.groups.push_back(group);
  for (const Transform& place : kPlaces) {
    InstanceDescription instance;
    for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = static_cast<float>(place.matrix().m[i / 4][i % 4]);
    d.instances.push_back(instance);
  }
  return d;
}

Description repeated_scene() {
  Description d = floor_scene();
  add_area_light_sphere(d, {0, -2.5f, 0.5f}, 0.1f, 50);  // the instances' lights are not the first
  const std::vector<ShapeDescription> shapes = glowing_shapes(d);
  for (const Transform& place : kPlaces)
    for (ShapeDescription shape : shapes) {
      shape.to_world = place * shape.to_world;
      d.shapes.push_back(shape);
    }
  return d;
}

}  // namespace

TEST_CASE("lights: instances emit as their shapes would in their place") {
  const auto instanced = compile_scene(instanced_scene()), repeated = compile_scene(repeated_scene());
  const SceneView a = instanced->view(), b = repeated->view();
  REQUIRE(a.lights.count == 13);
  REQUIRE(b.lights.count == 13);
  for (std::uint32_t i = 0; i < 13; ++i) {
    CAPTURE(i);
    const LightRow &x = a.lights.rows[i], &y = b.lights.rows[i];
    CHECK(x.kind == y.kind);
    CHECK(a.lights.powers[i].x == doctest::Approx(b.lights.powers[i].x).epsilon(1e-4));
    CHECK(a.lights.powers[i].y == doctest::Approx(b.lights.powers[i].y).epsilon(1e-4));
    CHECK(x.area == doctest::Approx(y.area).epsilon(1e-4));
    if (!x.is(LightKind::kMesh)) continue;
    for (std::uint32_t t = 0; t < x.triangle_count; ++t) {
      // The vertex order of mirrored shapes may differ; the plane may not.
      const auto &p = a.lights.triangles[x.first_triangle + t], &q = b.lights.triangles[y.first_triangle + t];
      CHECK(record_difference<Vec3>(p.normal, q.normal) < 1e-4);
    }
  }
}

TEST_CASE("lights: instances, by every strategy") {
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

TEST_CASE("lights: no shadow ray to a light of an instance ends in the light itself") {
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
      const Vec3f d = s.target - Vec3f{0, 0, 0.01f};
      packet.origin_x[lane] = packet.origin_y[lane] = 0;
      packet.origin_z[lane] = 0.01f;
      packet.direction_x[lane] = d.x;
      packet.direction_y[lane] = d.y;
      packet.direction_z[lane] = d.z;
      packet.t_far[lane] = 1;
      packet.shape[lane] = kNone;
    }
    view.accel->intersect(packet, 1);
    // A hit that is not far in front of the target would be the light itself.
    if (packet.shape[0] != kNone && packet.t_far[0] > 0.999f) ++blocked;
  }
  CHECK(valid > 3000);
  CHECK(blocked == 0);
}

TEST_CASE("lights: registers do as single values, whatever lights they hold") {
  Description d = instanced_scene();
  const TextureId one = add_board(d, {1, 2, 3}, {4, 5, 6}), two = add_board(d, {7, 1, 2}, {3, 4, 5});
  add_rectangle(d, kPlaces[0] * Transform::translate({2, 0, 0})).radiance = one;
  add_rectangle(d, kPlaces[2] * Transform::translate({-2, 0, 0})).radiance = two;
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
    const auto wide = sample_given_light<Wide>(view, origin, lights, random);
    for (int k = 0; k < kWidth; ++k) {
      const auto s = sample_given_light<Scalar>(view, from(k), load_lights<Scalar>(view, light_of(k)), u(k));
      CAPTURE(light_of(k));
      if (lane_of(wide.valid, k) != s.valid) continue;  // rounding, at an edge; counted below
      if (!s.valid) continue;
      ++seen[light_of(k)];
      CHECK(lane_of(wide.delta, k) == s.delta);
      CHECK(difference(wide.target.x[k], s.target.x) < 1e-4);
      CHECK(difference(wide.target.z[k], s.target.z) < 1e-4);
      CHECK(difference(wide.pdf_solid_angle[k], s.pdf_solid_angle) < 1e-3);
      // Squares of a board have hard edges.
      if (difference(wide.radiance.c1[k], s.radiance.c1) > 1e-3) CHECK(view.lights.rows[light_of(k)].texture != kNone);
    }
  }
  for (std::uint32_t i = 0; i < view.lights.count; ++i) {
    CAPTURE(i);
    CHECK(seen[i] > 20);
  }
}

TEST_CASE("lights: what cannot be is said where it stands") {
  const auto message = [](auto model) -> std::string {
    try {
      lone(model);
    } catch (const SceneError& error) { return error.what(); }
    return "";
  };
  SpotLightDescription spot;
  spot.beam_width = 30;
  CHECK(message(spot).starts_with("scene.xml:9: the beam of a spot light"));
  spot = {};
  spot.cutoff_angle = 0;
  CHECK(message(spot).find("between 0 and 180") != std::string::npos);
  DirectionalLightDescription nowhere;
  nowhere.direction = {0, 0, 0};
  CHECK(message(nowhere).find("no length") != std::string::npos);
  ProjectorDescription projector;
  projector.to_world = Transform::scale({1, 2, 1});
  CHECK(message(projector).find("stretched") != std::string::npos);
  projector = {};
  projector.fov = 180;
  CHECK(message(projector).find("field of view") != std::string::npos);
  spot = {};
  spot.texture = TextureId{3};
  CHECK(message(spot).find("does not exist") != std::string::npos);
}

namespace {

/// Thousands of a kind of shape or light side by side.
constexpr int kMany = 2000;

Transform place_of(int i) { return Transform::translate({static_cast<float>(i % 50), static_cast<float>(i / 50), 0}); }

/// Seconds of processor time that a description takes to become a scene, the least of three times.
double compile_seconds(const Description& d) {
  double least = 1e9;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();
    compile_scene(d);
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

}  // namespace

// Not under sanitizers, which slow some code down far more than other code.
TEST_SUITE_BEGIN("slow");

TEST_CASE("lights: nothing is integrated for each of thousands of lights and materials") {
  const auto many = [](auto&& add) {
    Description d = empty_scene(4, 4);
    for (int i = 0; i < kMany; ++i) add(d, i);
    return d;
  };
  // Flat disks, whose area is a product.
  const double disks = compile_seconds(many([](Description& d, int i) {
    emit(add_shape(d, DiskShape{}, place_of(i) * Transform::scale({0.1f, 0.1f, 1})), 1);
  }));
  const std::pair<const char*, Description> others[] = {
      {"spheres", many([](Description& d, int i) {
         emit(add_shape(d, SphereShape{{0, 0, 0}, 0.1f}, place_of(i)), 1);
       })},
      {"ellipsoids, each of its own shape", many([](Description& d, int i) {
         const float size = 0.1f + 1e-4f * static_cast<float>(i);
         emit(add_shape(d, SphereShape{}, place_of(i) * Transform::scale({0.1f, size, 2 * size})), 1);
       })},
      {"cylinders, each of its own shape", many([](Description& d, int i) {
         const float size = 0.1f + 1e-4f * static_cast<float>(i);
         emit(add_shape(d, CylinderShape{}, place_of(i) * Transform::scale({0.1f, size, 2 * size})), 1);
       })},
      {"textured lights of one texture", many([](Description& d, int i) {
         if (i == 0) add_board(d, {1, 2, 3}, {3, 2, 1});
         if (i % 2 == 0)
           add_shape(d, RectangleShape{}, place_of(i)).radiance = static_cast<TextureId>(0);
         else
           add_shape(d, SphereShape{}, place_of(i)).radiance = static_cast<TextureId>(0);
       })},
      {"spots", many([](Description& d, int i) {
         SpotLightDescription spot;
         spot.to_world = place_of(i);
         d.lights.push_back({spot, {}});
       })},
  };
  for (const auto& other : others) {
    const double seconds = compile_seconds(other.second);
    INFO(other.first << ": " << seconds << " s, disks " << disks << " s");
    // An integral for each takes from 20 to 200 times as long as a disk.
    CHECK(seconds < 6 * disks + 0.05);
  }
  // The fits of a few roughnesses serve all others; a fit for each takes seconds.
  const double plastics = compile_seconds(many([](Description& d, int i) {
    PlasticDescription plastic;
    const float alpha = 0.05f + 4e-4f * static_cast<float>(i);
    plastic.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, alpha, alpha};
    add_shape(d, DiskShape{}, place_of(i), add_material(d, plastic));
  }));
  INFO("plastics: " << plastics << " s, disks " << disks << " s");
  CHECK(plastics < 6 * disks + 0.5);
  // A texture of its own for each is looked up at hundreds of points and not at thousands.
  const double textured = compile_seconds(many([](Description& d, int i) {
    add_board(d, {1, 2, 3}, {3, static_cast<float>(i), 1});
    add_shape(d, RectangleShape{}, place_of(i)).radiance = static_cast<TextureId>(i);
  }));
  INFO("textures: " << textured << " s, disks " << disks << " s");
  CHECK(textured < 12 * disks + 0.1);
}

TEST_SUITE_END();

TEST_CASE("lights: powers of lights that share a texture's mean are those of each alone") {
  Description d = empty_scene(4, 4);
  const TextureId board = add_board(d, {8, 1, 0.5f}, {1, 3, 2});
  const Transform maps[] = {Transform(), Transform::rotate({1, 2, 3}, 40) * Transform::scale({2, 2, 2}),
                            Transform::scale({1, 1, 6}), Transform::scale({6, 1, 1}),
                            Transform::rotate({1, 2, 3}, 40) * Transform::scale({1, 1, 6})};
  for (const Transform& map : maps) {
    add_shape(d, SphereShape{}, map).radiance = board;
    add_shape(d, CylinderShape{}, map).radiance = board;
    add_shape(d, DiskShape{}, map).radiance = board;
    add_shape(d, RectangleShape{}, map).radiance = board;
    add_shape(d, CubeShape{}, map).radiance = board;
  }
  // The same corners, other uv
  Mesh half;
  half.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  half.uvs = {{0, 0}, {0.4f, 0}, {0, 0.4f}};
  half.triangles = {{0, 1, 2}};
  Mesh other = half;
  other.uvs = {{0.6f, 0}, {0.9f, 0}, {0.9f, 0.4f}};
  add_shape(d, half, Transform()).radiance = board;
  add_shape(d, other, Transform()).radiance = board;
  // The same shape and texture, other values of the mesh
  d.textures.push_back({MeshAttributeDescription{"face_color", 2}, {1, 0, 0, 0, 1, 0}, "", {}});
  for (const float value : {1.0f, 5.0f}) {
    half.attributes = {{"face_color", 3, {value, 0, 1}}};
    add_shape(d, half, Transform()).radiance = static_cast<TextureId>(d.textures.size() - 1);
  }
  for (const float cutoff : {30.0f, 50.0f}) {
    SpotLightDescription spot;
    spot.cutoff_angle = cutoff;
    spot.beam_width = 20;
    d.lights.push_back({spot, {}});
    spot.texture = board;
    d.lights.push_back({spot, {}});
  }
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  REQUIRE(view.lights.count == 5 * std::size(maps) + 4 + 4);
  for (std::uint32_t i = 0; i < view.lights.count; ++i) {
    CAPTURE(i);
    const Vec3f alone = light_power(view, i), together = view.lights.powers[i];
    CHECK(together.x == doctest::Approx(alone.x).epsilon(2e-4));
    CHECK(together.y == doctest::Approx(alone.y).epsilon(2e-4));
    CHECK(together.z == doctest::Approx(alone.z).epsilon(2e-4));
  }
}

}  // namespace sheaf::test_lights

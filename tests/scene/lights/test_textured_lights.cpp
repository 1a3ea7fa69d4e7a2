// Lights with textures and mesh attributes: agreement of all strategies, means and power.
#include "scene/compile/compile.h"
#include "scene/lights/light_powers.h"
#include "tests/scene/lights/floor_lighting.h"
#include "tests/support/near.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <iterator>

namespace sheaf::test_textured_lights {

using namespace floor_lighting;

TEST_CASE("lights: all strategies agree on textured lights of every shape" * doctest::test_suite("slow")) {
  Description d = floor_scene();
  const TextureId board = add_checkerboard(d, {6, 1, 1}, {2, 3, 1}), other = add_checkerboard(d, {1, 5, 1}, {9, 2, 1});
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

TEST_CASE("lights: a textured light has the mean of its texture") {
  Description d = floor_scene(), plain = floor_scene();
  const Transform above = Transform::translate({0, 0, 2}) * Transform::rotate({1, 0, 0}, 180);
  // The pattern maps to its complement under a rotation by 90 degrees: the point below sees the mean of both colors.
  add_rectangle(d, above, add_diffuse(d, 0)).radiance = add_checkerboard(d, {6, 6, 6}, {2, 2, 2});
  add_area_light_rectangle(plain, above, 4);
  const Result a = rendered(d), b = rendered(plain);
  CHECK(std::fabs(a.mean - b.mean) < 4.5 * std::hypot(a.error, b.error));
  const auto scene = compile_scene(d), other = compile_scene(plain);
  CHECK(scene->view().lights.powers[0].x == near(4 * kPiD * 4, 5e-3));
  CHECK(other->view().lights.powers[0].x == near(4 * kPiD * 4, 1e-5));
}

TEST_CASE("lights: a mesh attribute can be the radiance of a light") {
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
  CHECK(power.x == near(kPiD * 2 * 8));
  CHECK(power.y == near(kPiD * 2 * 4));
  CHECK(power.z == near(kPiD * 4 * 2));
}

TEST_CASE("lights: products, thresholds and other coordinates can be the radiance of a light") {
  Description d = floor_scene();
  const TextureId board = add_checkerboard(d, {6, 1, 1}, {2, 3, 1});
  const auto add = [&](const TextureModel& model) {
    d.textures.push_back({model, {1, 0, 0, 0, 1, 0}, "", {}});
    return static_cast<TextureId>(d.textures.size() - 1);
  };
  // The light shows the square (0.5, 0.5) of the board, of 6, where u is above 0.5, and nothing elsewhere.
  const TextureId moved = add(UvSetTextureDescription{"vertex_uv1", board});
  const TextureId right = add(ThresholdTextureDescription{add(MeshAttributeDescription{"vertex_u", 1}), 0.5f});
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.attributes.push_back({"vertex_uv1", 3, {0.5f, 0.5f, 0, 0.999f, 0.5f, 0, 0.999f, 0.999f, 0, 0.5f, 0.999f, 0}});
  mesh.attributes.push_back({"vertex_u", 1, {0, 1, 1, 0}});
  const Transform above = Transform::translate({0.4f, 0.1f, 1.5f}) * Transform::rotate({1, 0, 0}, 180);
  add_shape(d, mesh, above, add_diffuse(d, 0)).radiance = add(ProductTextureDescription{moved, right});
  const double mean = agreed(d);
  const Vec3f power = compile_scene(d)->view().lights.powers[0];
  CHECK(power.x == near(kPiD * 2 * 6, 5e-3));
  CHECK(power.y == near(kPiD * 2 * 1, 5e-3));
  // The same light as half of the rectangle
  Description half = floor_scene();
  add_area_light_rectangle(half, above * Transform::translate({0.5f, 0, 0}) * Transform::scale({0.5f, 1, 1}), 6);
  const Result expected = rendered(half);
  CHECK(std::fabs(mean - expected.mean) < 0.02 * expected.mean);
}

TEST_CASE("lights: lights that share the mean of a texture have the same power as separate ones") {
  Description d = empty_scene(4, 4);
  const TextureId board = add_checkerboard(d, {8, 1, 0.5f}, {1, 3, 2});
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
  // The same corners with other uv
  Mesh half;
  half.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  half.uvs = {{0, 0}, {0.4f, 0}, {0, 0.4f}};
  half.triangles = {{0, 1, 2}};
  Mesh other = half;
  other.uvs = {{0.6f, 0}, {0.9f, 0}, {0.9f, 0.4f}};
  add_shape(d, half, Transform()).radiance = board;
  add_shape(d, other, Transform()).radiance = board;
  // The same shape and texture with other attribute values
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
    CHECK(together.x == near(alone.x, 2e-4));
    CHECK(together.y == near(alone.y, 2e-4));
    CHECK(together.z == near(alone.z, 2e-4));
  }
}

}  // namespace sheaf::test_textured_lights

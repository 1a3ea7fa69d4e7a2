// Lookups of grid textures, mesh attributes, volumes and wireframes, and of values for material parameters.
#include "scene/textures/texture_lookup.h"

#include "core/color/color.h"
#include "scene/compile/compile.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/formats/mesh.h"
#include "tests/scene/textures/texture_lookups.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace sheaf::test_texture_lookup {

using namespace texture_lookups;

TEST_CASE("texture lookup: grid lines are at integral u and v") {
  TextureDescription grid;
  grid.model = GridTextureDescription{SpectrumDescription::constant(0.25f), SpectrumDescription::rgb(1, 2, 3), 0.1f};
  grid.to_uv = {2, 0, 0, 0, 1, 0.5f};
  const TextureTables compiled = compile_textures({grid});
  const TextureView view = view_of(compiled);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const TextureQuery<Scalar> q = random_query(i);
    const double u = 2.0 * q.uv.x, v = q.uv.y + 0.5;
    const double from_line = std::min(std::abs(u - std::round(u)), std::abs(v - std::round(v)));
    if (std::abs(from_line - 0.1) < 1e-5) continue;
    CHECK(lookup_texture<Scalar>(view, 0, q).c1 == (from_line < 0.1 ? 2.0f : 0.25f));
    CHECK(lanes_agree(view, 0, [&](int k) { return random_query(i + 7 * static_cast<std::uint32_t>(k)); }));
  }
  grid.model = GridTextureDescription{SpectrumDescription::constant(0), SpectrumDescription::constant(1), -0.1f};
  CHECK_THROWS_AS(compile_textures({grid}), SceneError);
}

TEST_CASE("texture lookup: mesh attributes of vertices and faces are interpolated") {
  TextureDescription descriptions[4];
  const char* names[] = {"vertex_color", "vertex_weight", "face_color", "face_missing"};
  for (int i = 0; i < 4; ++i) descriptions[i].model = MeshAttributeDescription{names[i], i == 0 ? 2.0f : 1.0f};
  TextureTables textures = compile_textures({std::begin(descriptions), std::end(descriptions)});
  // Shape 1 has triangles 2 and 3 of the scene, with the vertices (0, 1, 2) and (2, 1, 3) of the shape.
  const std::uint32_t triangles[] = {9, 9, 9, 9, 9, 9, 0, 1, 2, 2, 1, 3, 0, 0, 0};
  AttributeTable table(textures.attribute_names);
  table.add(1, 2, 2, 4, {"vertex_color", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0.5f}}, {});
  table.add(1, 2, 2, 4, {"vertex_weight", 1, {1, 2, 4, 8}}, {});
  table.add(1, 2, 2, 4, {"face_color", 3, {1, 2, 3, 4, 5, 6}}, {});
  table.finish(3);
  TextureView view = view_of(textures);
  view.attributes = table.entries().data();
  view.attribute_values = table.values().data();
  view.triangles = triangles;
  view.shape_count = 3;

  const TextureQuery<Scalar> second{{0, 0}, 1, 1, 0.25f, 0.5f};
  const Spectrum4 color = lookup_texture<Scalar>(view, 0, second);
  CHECK(color.c0 == near(2 * (0.25 * 0 + 0.25 * 0 + 0.5 * 1)));
  CHECK(color.c1 == near(2 * (0.25 * 0 + 0.25 * 1 + 0.5 * 1)));
  CHECK(color.c2 == near(2 * (0.25 * 1 + 0.25 * 0 + 0.5 * 0.5)));
  CHECK(lookup_scalar<Scalar>(view, 0, second) == near(luminance({color.c0, color.c1, color.c2})));
  const TextureQuery<Scalar> first{{0, 0}, 1, 0, 0.25f, 0.5f};
  CHECK(lookup_scalar<Scalar>(view, 1, first) == near(0.25 * 1 + 0.25 * 2 + 0.5 * 4));
  CHECK(lookup_texture<Scalar>(view, 1, first).c2 == lookup_scalar<Scalar>(view, 1, first));
  CHECK(lookup_texture<Scalar>(view, 2, first).c1 == 2.0f);
  CHECK(lookup_texture<Scalar>(view, 2, second).c2 == 6.0f);
  CHECK(max_component(lookup_texture<Scalar>(view, 3, second)) == 0.0f);
  for (const std::uint32_t other : {0u, 2u})
    for (std::uint32_t texture = 0; texture < 4; ++texture)
      CHECK(max_component(lookup_texture<Scalar>(view, texture, {{0, 0}, other, 0, 0.3f, 0.3f})) == 0.0f);

  for (std::uint32_t texture = 0; texture < 4; ++texture)
    for (std::uint32_t i = 0; i < 20; ++i)
      CHECK(lanes_agree(view, texture, [&](int k) {
        const auto r = i * 8 + static_cast<std::uint32_t>(k);
        return TextureQuery<Scalar>{{0, 0},
                                    r % 5 < 3 ? r % 3 : 0xffffffffu,
                                    r % 7 < 5 ? r % 2 : 0xfffffff0u,
                                    0.5f * uniform(r, 5),
                                    0.5f * uniform(r, 6)};
      }));
}

TEST_CASE("texture lookup: volumes are evaluated at the position in world space") {
  const TemporaryFolder folder;
  const auto colors = write_vol(folder / "rgb.vol", 8, 3, [](Vec3f p, int c) {
    return c == 0 ? p.x : c == 1 ? p.y : p.z;
  });
  const auto numbers = write_vol(folder / "grey.vol", 8, 1, [](Vec3f p, int) { return p.x * p.z; });
  TextureDescription rgb, gray, nearest;
  // The cube [1, 3] x [0, 2] x [0, 2].
  const Transform position = Transform::translate({1, 0, 0}) * Transform::scale({2, 2, 2});
  rgb.model = VolumeTextureDescription{vol(colors, position), 0.5f};
  gray.model = VolumeTextureDescription{vol(numbers, position), 1};
  VolumeTextureDescription blocks{vol(colors, position), 1};
  blocks.grid.filter = GridFilter::kNearest;
  blocks.grid.wrap = GridVolumeDescription::Wrap::kRepeat;
  nearest.model = blocks;
  const TextureTables compiled = compile_textures({rgb, gray, nearest});
  const TextureView view = view_of(compiled);
  const auto at = [](Vec3f p) { return TextureQuery<Scalar>{{0.9f, 0.1f}, 0, 0, 0, 0, p}; };
  const Spectrum4 color = lookup_texture<Scalar>(view, 0, at({2.2f, 1.5f, 0.3f}));
  CHECK(record_difference<Spectrum>(color, {0.5f * 0.6f, 0.5f * 0.75f, 0.5f * 0.15f, 0}) < 1e-5);
  CHECK(lookup_scalar<Scalar>(view, 0, at({2.2f, 1.5f, 0.3f})) == near(luminance({0.3f, 0.375f, 0.075f})));
  CHECK(lookup_texture<Scalar>(view, 0, at({9, 1, 1})).c0 == near(0.5 * 15 / 16));
  // At voxel centers products are exact.
  CHECK(lookup_scalar<Scalar>(view, 1, at({1 + 2 * 5.5f / 8, 1, 2 * 2.5f / 8})) == near(5.5 / 8 * 2.5 / 8));
  CHECK(lookup_texture<Scalar>(view, 1, at({1 + 2 * 5.5f / 8, 1, 2 * 2.5f / 8})).c2 == near(5.5 * 2.5 / 64));
  CHECK(lookup_texture<Scalar>(view, 2, at({1.1f + 2, 0.9f, 0.1f})).c0 == near(0.5 / 8));
  CHECK(lookup_texture<Scalar>(view, 2, at({1.1f, 0.9f, 0.1f})).c1 == near(3.5 / 8));
  for (std::uint32_t texture = 0; texture < 3; ++texture)
    CHECK(lanes_agree(view, texture, [&](int k) {
      const auto r = static_cast<std::uint32_t>(k);
      return at({4 * uniform(r, 5), 4 * uniform(r, 6) - 1, 4 * uniform(r, 7) - 1});
    }));
}

TEST_CASE("texture lookup: volumes as light or bump textures are rejected") {
  const TemporaryFolder folder;
  const auto numbers = write_vol(folder / "grey.vol", 2, 1, [](Vec3f, int) { return 0.5f; });
  Description d = empty_scene(1, 1);
  TextureDescription texture;
  texture.model = VolumeTextureDescription{vol(numbers), 1};
  d.textures.push_back(texture);
  const MaterialId gray = add_diffuse(d, 0.5f);
  add_sphere(d, {0, 0, 0}, 1, gray).radiance = TextureId{0};
  CHECK_THROWS_WITH_AS(compile_scene(d), doctest::Contains("a grid in the world, expected one that follows"),
                       SceneError);
  TextureDescription board;
  board.model = CheckerboardDescription{SpectrumDescription::constant(1), TextureId{0}};
  d.textures.push_back(board);
  d.shapes[0].radiance = TextureId{1};
  CHECK_THROWS_AS(compile_scene(d), SceneError);
  d.textures[1].model = MixTextureDescription{SpectrumDescription::constant(1), TextureId{0}, 0.5f};
  CHECK_THROWS_AS(compile_scene(d), SceneError);
  d.shapes[0].radiance.reset();
  CHECK_NOTHROW(compile_scene(d));
  d.shapes[0].material = add_material(d, BumpMapDescription{TextureId{0}, 1, gray});
  CHECK_THROWS_WITH_AS(compile_scene(d), doctest::Contains("expected a texture over uv"), SceneError);
}

TEST_CASE("texture lookup: wireframes follow the edges of triangles") {
  TextureDescription fixed, relative;
  fixed.model =
      WireframeDescription{SpectrumDescription::rgb(1, 0.5f, 0), SpectrumDescription::constant(0), 0.4f, 0.5f};
  relative.model = WireframeDescription{SpectrumDescription::constant(1), SpectrumDescription::constant(0), 0, 0};
  TextureTables textures = compile_textures({fixed, relative});
  // A right triangle with legs 3 and 4, and one twice as large.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}, {0, 0, 1}, {6, 0, 1}, {0, 8, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::uint32_t triangles[] = {0, 1, 2, 3, 4, 5, 0, 0, 0};
  AttributeTable table(textures.attribute_names);
  table.add(0, 0, 2, 6, {kEdgeDistances, 3, edge_distances(mesh, false)}, {});
  table.add(0, 0, 2, 6, {kRelativeEdgeDistances, 3, edge_distances(mesh, true)}, {});
  table.finish(2);
  TextureView view = view_of(textures);
  view.attributes = table.entries().data();
  view.attribute_values = table.values().data();
  view.triangles = triangles;
  view.shape_count = 2;

  const auto at = [&](std::uint32_t texture, std::uint32_t triangle, float x, float y) {
    const float scale = triangle == 0 ? 1.0f : 2.0f;
    return lookup_texture<Scalar>(view, texture, {{0, 0}, 0, triangle, x / (3 * scale), y / (4 * scale)});
  };
  // In the middle of the smooth step: 3/4 of the line width.
  for (const std::uint32_t triangle : {0u, 1u}) {
    CHECK(at(0, triangle, 1, 0.3f).c0 == near(0.5));
    CHECK(at(0, triangle, 0.3f, 1).c1 == near(0.25));
    CHECK(at(0, triangle, 1, 0.19f).c0 == 0.0f);
    CHECK(at(0, triangle, 1, 0.41f).c0 == near(1));
    CHECK(at(0, triangle, 1, 0.41f).c2 == 0.0f);
  }
  // 0.3 from the hypotenuse, whose unit normal is (0.8, 0.6).
  CHECK(at(0, 0, 1.5f - 0.3f * 0.8f, 2 - 0.3f * 0.6f).c0 == near(0.5, 1e-3));
  // The mean edge length is 6: lines of width 0.6 without a smooth step.
  CHECK(at(1, 1, 1, 0.59f).c0 == 0.0f);
  CHECK(at(1, 1, 1, 0.61f).c0 == 1.0f);
  CHECK(lookup_scalar<Scalar>(view, 0, {{0, 0}, 0, 0, 1.0f / 3, 0.1f}) == near(luminance({1, 0.5f, 0})));
  CHECK(lookup_texture<Scalar>(view, 0, {{0, 0}, 1, 0, 0, 0}).c0 == 1.0f);  // a shape without triangles
  for (std::uint32_t i = 0; i < 50; ++i)
    CHECK(lanes_agree(view, 0, [&](int k) {
      const auto r = i * 8 + static_cast<std::uint32_t>(k);
      return TextureQuery<Scalar>{{0, 0}, r % 5 == 0 ? 1u : 0u, r % 2, 0.5f * uniform(r, 5), 0.5f * uniform(r, 6)};
    }));
}

TEST_CASE("texture lookup: bindings give numbers or reflectances or unbounded colors") {
  TextureDescription board;
  board.model = CheckerboardDescription{SpectrumDescription::rgb(3, 0.5f, -1), SpectrumDescription::rgb(3, 0.5f, -1)};
  const TextureTables compiled = compile_textures({board});
  const TextureView view = view_of(compiled);
  const auto bound = [&](std::uint32_t words, TextureRole role) {
    return lookup_binding<Scalar>(view, {0, 0, words, role}, query_at(0, 0));
  };
  const float red = lookup_texture<Scalar>(view, 0, query_at(0, 0)).c0,
              blue = lookup_texture<Scalar>(view, 0, query_at(0, 0)).c2;
  CHECK(red == 3.0f);
  CHECK(bound(1, TextureRole::kScalar).c0 == near(luminance({red, 0.5f, blue})));
  CHECK(bound(4, TextureRole::kReflectance).c0 == 1.0f);
  CHECK(bound(4, TextureRole::kReflectance).c1 == 0.5f);
  CHECK(bound(4, TextureRole::kReflectance).c2 == 0.0f);
  CHECK(bound(4, TextureRole::kReflectance).c3 == 0.0f);
  CHECK(bound(4, TextureRole::kUnbounded).c0 == 3.0f);
}

}  // namespace sheaf::test_texture_lookup

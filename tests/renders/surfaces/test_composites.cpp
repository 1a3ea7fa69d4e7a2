// Masks, blends, null interfaces and maps: rows of the material table, and renders against closed forms.
#include "core/image/exr.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/compile/compile_materials.h"
#include "tests/support/near.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

namespace sheaf::test_composites {

namespace {

constexpr double kPiD = 3.14159265358979323846;
const double kLevel = significance_of_each(60);

Description small_scene() {
  Description d = empty_scene(32, 32);
  d.sampler.sample_count = 64;
  d.sampler.seed = 11;
  return d;
}

/// The camera sees one point of a floor at z = 0 with normal +z, from 30 degrees off the normal.
void aim_at_floor(Description& d) { look_at(d, {2, 0, 3.4641016f}, {0, 0, 0}, {0, 0, 1}, 0.01f); }

/// Tests the mean of the image against `expected`. Noise-free images must equal it.
void check_mean(const Description& d, double expected) {
  const Image image = render(*compile_scene(d), {}).film.to_image();
  MeanVariance statistics;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) statistics.add(image.at(x, y, 1));
  INFO("mean " << statistics.mean() << ", expected " << expected);
  if (std::fabs(statistics.mean() - expected) > 2e-5 * expected) CHECK(statistics.p_value(expected) >= kLevel);
}

TextureId add_bitmap(Description& d, const TemporaryFolder& folder, const char* name, int width, int height,
                     const std::vector<float>& rgb) {
  Image image(width, height, {"R", "G", "B"});
  image.data = rgb;
  write_exr(folder.path() / name, image, {});
  BitmapDescription bitmap;
  bitmap.file = folder.path() / name;
  bitmap.filter = TextureFilter::kNearest;
  d.textures.push_back({bitmap, {1, 0, 0, 0, 1, 0}, {}, {}});
  return static_cast<TextureId>(d.textures.size() - 1);
}

/// A texture of the constant color (r, g, b).
TextureId add_uniform(Description& d, const TemporaryFolder& folder, const char* name, float r, float g, float b) {
  return add_bitmap(d, folder, name, 1, 1, {r, g, b});
}

double cosine_degrees(double degrees) { return std::cos(degrees * kPiD / 180); }

}  // namespace

TEST_CASE("compile materials: two-sided blends choose between the sides of their parts") {
  Description d;
  const MaterialId a = add_diffuse(d, 0.1f), b = add_diffuse(d, 0.2f), c = add_diffuse(d, 0.3f);
  const MaterialId blend = add_material(d, BlendDescription{0.25f, {a, b}});
  const MaterialId sides = add_material(d, TwoSidedDescription{blend, c});
  const CompiledMaterials out = compile_materials(d.materials);
  const MaterialRow& front = out.tables.rows.at(out.row_of.at(static_cast<std::size_t>(sides)));
  CHECK((front.flags & kComposite) != 0);
  CHECK(front.words[0] == 0.25f);
  CHECK(out.tables.rows.at(front.choice[0]).words[0] == near(0.1f));
  CHECK(out.tables.rows.at(front.choice[1]).words[0] == near(0.2f));
  for (const std::uint32_t choice : front.choice) CHECK((out.tables.rows.at(choice).flags & kTwoSided) != 0);
  const MaterialRow& back = out.tables.rows.at(front.back);
  CHECK(back.words[0] == near(0.3f));
  CHECK((back.flags & kTwoSided) != 0);
  // Without two-sided, the same blend is one-sided.
  const MaterialRow& alone = out.tables.rows.at(out.row_of.at(static_cast<std::size_t>(blend)));
  CHECK((out.tables.rows.at(alone.choice[0]).flags & kTwoSided) == 0);
  CHECK(&out.tables.rows.at(alone.back) == &alone);
}

TEST_CASE("compile materials: textures are bound to the right parameters") {
  Description d;
  RoughnessDescription roughness{RoughnessDescription::Distribution::kGgx, TextureId{3}, 0.2f};
  ConductorDescription metal;
  metal.ior = {SpectrumDescription::constant(0.2f), TextureId{5}};
  metal.roughness = roughness;
  add_material(d, metal);
  const CompiledMaterials out = compile_materials(d.materials);
  const MaterialRow& row = out.tables.rows.at(out.row_of[0]);
  CHECK(row.kind == kClosureKind<RoughConductorGgxClosure>);
  CHECK((row.flags & kNeedsUv) != 0);
  REQUIRE(row.binding_count == 2);
  const TextureBinding& k = out.tables.bindings.at(row.first_binding);
  const TextureBinding& alpha = out.tables.bindings.at(row.first_binding + 1);
  CHECK(k.texture == 5);
  CHECK(k.word == 4);
  CHECK(k.words == 4);
  CHECK(k.role == TextureRole::kUnbounded);
  CHECK(alpha.texture == 3);
  CHECK(alpha.word == 12);
  CHECK(alpha.words == 1);
  CHECK(row.words[13] == 0.2f);
}

TEST_CASE("compile materials: invalid combinations are rejected") {
  const auto fails = [](auto&& build, const char* what) {
    Description d;
    build(d);
    CHECK_THROWS_WITH_AS(compile_materials(d.materials), doctest::Contains(what), SceneError);
  };
  fails([](Description& d) { add_two_sided(d, add_glass(d)); }, "transmits");
  fails([](Description& d) { add_two_sided(d, add_material(d, NullDescription{})); }, "transmits");
  fails(
      [](Description& d) {
        add_two_sided(d, add_material(d, MaskDescription{0.5f, add_diffuse(d, 1)}));
      },
      "transmits");
  fails([](Description& d) { add_two_sided(d, add_two_sided(d, add_diffuse(d, 1))); }, "cannot hold another");
  fails(
      [](Description& d) {
        const MaterialId inner = add_material(d, BumpMapDescription{TextureId{0}, 1, add_diffuse(d, 1)});
        add_material(d, NormalMapDescription{TextureId{0}, false, inner});
      },
      "map cannot hold another");
  fails(
      [](Description& d) {
        for (std::uint32_t i = 0; i < 20; ++i) add_material(d, MaskDescription{0.5f, MaterialId{i + 1}});
        add_diffuse(d, 1);
      },
      "deep");
}

TEST_SUITE_BEGIN("slow");

TEST_CASE("composites: a mask transmits the uncovered share") {
  for (const float opacity : {0.0f, 0.3f, 1.0f}) {
    CAPTURE(opacity);
    Description d = small_scene();
    const MaterialId mask = add_material(d, MaskDescription{opacity, add_diffuse(d, 0.5f)});
    // The camera sees a masked sheet in front of a bright one. The sheet itself is lit by a constant environment.
    add_rectangle(d, Transform::translate({0, 0, 2}) * Transform::rotate({1, 0, 0}, 180), mask);
    add_constant_light(d, 1);
    d.camera.fov = 0.01f;
    // Either half of the environment's radiance is reflected, or the environment itself is visible.
    check_mean(d, opacity * 0.5 + (1 - opacity));
  }
}

TEST_CASE("composites: null interfaces change nothing and do not cost depth") {
  Description d = small_scene();
  add_rectangle(d, Transform::scale({20, 20, 1}), add_diffuse(d, 0.6f));
  aim_at_floor(d);
  d.integrator.max_depth = 2;
  add_constant_light(d, 1);
  const MaterialId null = add_material(d, NullDescription{});
  for (int i = 1; i <= 5; ++i) add_sphere(d, {0, 0, 0}, 0.3f * static_cast<float>(i), null);
  check_mean(d, 0.6);
}

TEST_CASE("composites: a blend is the mixture of its parts") {
  Description d = small_scene();
  const MaterialId parts[2] = {add_diffuse(d, 0.2f), add_diffuse(d, 0.8f)};
  const MaterialId inner = add_material(d, BlendDescription{0.5f, {parts[0], parts[1]}});
  add_rectangle(d, Transform::scale({20, 20, 1}), add_material(d, BlendDescription{0.25f, {inner, parts[1]}}));
  aim_at_floor(d);
  add_constant_light(d, 1);
  check_mean(d, 0.75 * 0.5 + 0.25 * 0.8);
}

TEST_CASE("textures: the colors of an image are those of the surface") {
  const TemporaryFolder folder;
  // The lower row is 0.1 and 0.2, the upper row 0.3 and 0.4. Files begin with the upper row.
  for (int quarter = 0; quarter < 4; ++quarter) {
    CAPTURE(quarter);
    Description d = small_scene();
    const auto gray = [](float v) { return std::vector<float>{v, v, v}; };
    std::vector<float> texels;
    for (const float v : {0.3f, 0.4f, 0.1f, 0.2f})
      for (const float c : gray(v)) texels.push_back(c);
    const TextureId texture = add_bitmap(d, folder, "quarters.exr", 2, 2, texels);
    const float x = quarter % 2 == 0 ? -0.5f : 0.5f, y = quarter / 2 == 0 ? -0.5f : 0.5f;
    add_rectangle(d, Transform::translate({-x, -y, 0}), add_material(d, DiffuseDescription{texture}));
    aim_at_floor(d);
    add_constant_light(d, 1);
    check_mean(d, 0.1 + 0.1 * quarter);
  }
}

TEST_CASE("textures: opacity may vary with a texture") {
  const TemporaryFolder folder;
  Description d = small_scene();
  const TextureId opacity = add_uniform(d, folder, "opacity.exr", 0.25f, 0.25f, 0.25f);
  add_rectangle(d, Transform::scale({5, 5, 1}),
                add_material(d, MaskDescription{opacity, add_two_sided(d, add_diffuse(d, 0))}));
  aim_at_floor(d);
  add_constant_light(d, 1);
  check_mean(d, 0.75);
}

TEST_CASE("normal maps: mapped normals receive light by their own cosine") {
  const TemporaryFolder folder;
  // A normal 20 degrees off the floor's towards +x, under a directional light 60 degrees off the normal.
  const float tilt = 20 * static_cast<float>(kPiD) / 180;
  const Vec3f light{std::sin(static_cast<float>(kPiD) / 3), 0, std::cos(static_cast<float>(kPiD) / 3)};
  const double lit = 0.5 / kPiD * cosine_degrees(40);
  const double tan2_tilt = std::pow(std::tan(20 * kPiD / 180), 2), tan2_light = std::pow(std::tan(60 * kPiD / 180), 2);
  const double softened = lit * 2 / (1 + std::sqrt(1 + 0.125 * tan2_tilt * tan2_light));
  const auto scene = [&](bool soften, bool flip_green, float angle, bool from_behind = false) {
    Description d = small_scene();
    // The normal is rotated by `angle` degrees about the floor's normal, against the texture's x axis.
    const float phi = angle * static_cast<float>(kPiD) / 180;
    const Vec3f n{std::sin(tilt) * std::cos(phi), std::sin(tilt) * std::sin(phi), std::cos(tilt)};
    const TextureId map = add_uniform(d, folder, "map.exr", 0.5f * n.x + 0.5f, 0.5f * n.y + 0.5f, 0.5f * n.z + 0.5f);
    const MaterialId m =
        add_material(d, NormalMapDescription{map, flip_green, add_diffuse(d, 0.5f), {.soften_terminator = soften}});
    if (from_behind) {
      // Seen from behind, the map is mirrored at the floor.
      add_rectangle(d, Transform::rotate({0, 0, 1}, flip_green ? -angle : angle) * Transform::rotate({1, 0, 0}, 180),
                    add_two_sided(d, m));
    } else {
      add_rectangle(d, Transform::rotate({0, 0, 1}, flip_green ? angle : -angle), m);
    }
    aim_at_floor(d);
    add_point_light(d, light * 1000.0f, 1e6f);
    return d;
  };
  check_mean(scene(false, false, 0), lit);
  check_mean(scene(true, false, 0), softened);
  check_mean(scene(false, false, 70), lit);
  check_mean(scene(false, true, 70), lit);
  for (const bool flip_green : {false, true}) check_mean(scene(false, flip_green, 70, true), lit);
}

TEST_CASE("normal maps: flat normal maps and bump maps change nothing") {
  const TemporaryFolder folder;
  for (const bool bump : {false, true}) {
    Description d = small_scene();
    const TextureId map = add_uniform(d, folder, "up.exr", 0.5f, 0.5f, 1);
    const MaterialId nested = add_diffuse(d, 0.5f);
    const MaterialId m = bump ? add_material(d, BumpMapDescription{map, 3, nested})
                              : add_material(d, NormalMapDescription{map, false, nested});
    add_rectangle(d, Transform(), m);
    aim_at_floor(d);
    add_constant_light(d, 1);
    check_mean(d, 0.5);
  }
}

TEST_CASE("bump maps: the normal is that of the displaced surface") {
  const TemporaryFolder folder;
  Description d = small_scene();
  // Heights 0 and 0.5 at u = 1/4 and 3/4 give a slope of 1 per unit of u, or 0.5 per unit of length.
  const TextureId map = add_bitmap(d, folder, "slope.exr", 2, 1, {0, 0, 0, 0.5f, 0.5f, 0.5f});
  std::get<BitmapDescription>(d.textures.back().model).filter = TextureFilter::kBilinear;
  const MaterialId m = add_material(d, BumpMapDescription{map, 1, add_diffuse(d, 0.5f), {.soften_terminator = false}});
  add_rectangle(d, Transform(), m);
  aim_at_floor(d);
  const Vec3f light{-0.6f, 0, 0.8f};
  add_point_light(d, light * 1000.0f, 1e6f);
  const double slope = 0.5;
  const double cosine = (slope * 0.6 + 0.8) / std::sqrt(1 + slope * slope);
  check_mean(d, 0.5 / kPiD * cosine);
}

TEST_CASE("normal maps: normals that face away from the viewer are flipped") {
  const TemporaryFolder folder;
  Description d = small_scene();
  // The camera looks from 30 degrees off the normal towards +x. The mapped normal is 80 degrees off towards -x.
  const float tilt = 80 * static_cast<float>(kPiD) / 180;
  const TextureId map =
      add_uniform(d, folder, "away.exr", 0.5f - 0.5f * std::sin(tilt), 0.5f, 0.5f + 0.5f * std::cos(tilt));
  const MaterialId m =
      add_material(d, NormalMapDescription{map, false, add_diffuse(d, 0.5f), {.soften_terminator = false}});
  add_rectangle(d, Transform(), m);
  aim_at_floor(d);
  add_point_light(d, {1000, 0, 1000}, 2e6f);
  // The flipped normal is 80 degrees off towards +x, 35 degrees from the light.
  check_mean(d, 0.5 / kPiD * cosine_degrees(35));
  std::get<NormalMapDescription>(d.materials.back().model).options.fix_invalid_normals = false;
  check_mean(d, 0);
}

TEST_SUITE_END();

}  // namespace sheaf::test_composites

// Products, thresholds, directions and textures at other coordinates.
#include "core/image/exr.h"
#include "core/io/error.h"
#include "scene/compile/compile.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/textures/texture_lookup.h"
#include "tests/scene/textures/texture_lookups.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace sheaf::test_texture_composition {

using namespace texture_lookups;

namespace {

TextureDescription texture(const TextureModel& model) { return {model, {1, 0, 0, 0, 1, 0}, "", {}}; }

/// An image of floats; `values` are interleaved, from the upper left.
TextureDescription image_texture(const std::filesystem::path& file, int width, int height, int channels,
                                 const std::vector<float>& values) {
  Image image(width, height, channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"});
  image.data = values;
  write_exr(file, image);
  BitmapDescription bitmap;
  bitmap.file = file;
  return texture(bitmap);
}

/// Textures with the attribute vertex_uv1 of shape 1: triangle 0 has the corners (0, 0), (1, 0), (0, 1), triangle 1
/// (0.75, 0.25) at all three.
struct WithUvs {
  explicit WithUvs(const std::vector<TextureDescription>& descriptions) : textures(compile_textures(descriptions)) {
    AttributeTable table(textures.attribute_names);
    const float u = 0.75f, v = 0.25f;
    table.add(1, 0, 2, 6, {"vertex_uv1", 3, {0, 0, 9, 1, 0, 9, 0, 1, 9, u, v, 9, u, v, 9, u, v, 9}}, {});
    table.finish(2);
    entries = table.entries();
    values = table.values();
    view = view_of(textures);
    view.attributes = entries.data();
    view.attribute_values = values.data();
    view.triangles = triangles;
    view.shape_count = 2;
  }

  TextureTables textures;
  std::vector<AttributeEntry> entries;
  std::vector<float> values;
  std::uint32_t triangles[6] = {0, 1, 2, 3, 4, 5};
  TextureView view;
};

}  // namespace

TEST_CASE("product textures: colors and scalars are multiplied, slopes follow the product rule") {
  const TemporaryFolder folder;
  // Heights 1 to 3 over u, and 2 to 10 over v
  const TextureDescription a = image_texture(folder / "a.exr", 2, 1, 1, {1, 3}),
                           b = image_texture(folder / "b.exr", 1, 2, 1, {10, 2});
  const TextureDescription both = texture(ProductTextureDescription{TextureId{0}, TextureId{1}});
  const TextureDescription color =
      texture(ProductTextureDescription{SpectrumDescription::rgb(0.5f, 2, 4), TextureId{0}});
  const TextureTables textures = compile_textures({a, b, both, color});
  const TextureView view = view_of(textures);
  // Texel centers are at 1/4 and 3/4: at u = v = 0.4 the factors are 1 + 0.3 * 2 and 2 + 0.3 * 8.
  const TextureQuery<Scalar> query = query_at(0.4f, 0.4f);
  CHECK(lookup_scalar<Scalar>(view, 2, query) == near(1.6 * 4.4));
  CHECK(lookup_texture<Scalar>(view, 2, query).c1 == near(1.6 * 4.4));
  const Vec2f slopes = lookup_scalar_gradient<Scalar>(view, 2, query);
  CHECK(slopes.x == near(4 * 4.4));
  CHECK(slopes.y == near(1.6 * 16));
  const Spectrum4 rgb = lookup_texture<Scalar>(view, 3, query);
  CHECK(rgb.c0 == near(0.5 * 1.6));
  CHECK(rgb.c1 == near(2 * 1.6));
  CHECK(rgb.c2 == near(4 * 1.6));
  CHECK(rgb.c3 == 0.0f);
  for (std::uint32_t i = 0; i < 50; ++i)
    for (const std::uint32_t row : {2u, 3u})
      CHECK(lanes_agree(view, row, [&](int k) { return random_query(i + 50 * static_cast<std::uint32_t>(k)); }));
}

TEST_CASE("product textures: scaling scales one factor, and products of ones are exactly one") {
  const TextureModel product = ProductTextureDescription{SpectrumDescription::constant(1), SpectrumDescription()};
  const auto by_three = [](const SpectrumInput&) -> SpectrumInput { return SpectrumDescription::constant(3); };
  ProductTextureDescription ones;
  TextureModel scaled = scaled_texture(ones, 3, by_three);
  const TextureTables textures = compile_textures({texture(ones), texture(scaled), texture(product)});
  const TextureView view = view_of(textures);
  CHECK(lookup_scalar<Scalar>(view, 0, query_at(0, 0)) == 1.0f);
  CHECK(lookup_scalar<Scalar>(view, 1, query_at(0, 0)) == 3.0f);
  CHECK(lookup_texture<Scalar>(view, 1, query_at(0, 0)).c1 == 3.0f);
  CHECK(lookup_scalar<Scalar>(view, 2, query_at(0, 0)) == 0.0f);
}

TEST_CASE("threshold textures: 1 from the threshold on and 0 below") {
  const TemporaryFolder folder;
  TextureDescription ramp = image_texture(folder / "a.exr", 4, 1, 1, {0.25f, 0.5f, 0.75f, 1});
  std::get<BitmapDescription>(ramp.model).filter = TextureFilter::kNearest;
  TextureModel scaled = scaled_texture(ThresholdTextureDescription{TextureId{0}, 0.75f}, 0.5f,
                                       [](const SpectrumInput& color) { return color; });
  const TextureTables textures = compile_textures({ramp, texture(ThresholdTextureDescription{TextureId{0}}),
                                                   texture(scaled), texture(ThresholdTextureDescription{0.3f, 0.3f}),
                                                   texture(ThresholdTextureDescription{0.3f, 0.4f})});
  const TextureView view = view_of(textures);
  const float expected[2][4] = {{0, 1, 1, 1}, {0, 0, 0.5f, 0.5f}};
  for (std::uint32_t row = 0; row < 2; ++row)
    for (std::uint32_t x = 0; x < 4; ++x) {
      const TextureQuery<Scalar> query = query_at((static_cast<float>(x) + 0.5f) / 4, 0.5f);
      CHECK(lookup_scalar<Scalar>(view, row + 1, query) == expected[row][x]);
      CHECK(lookup_texture<Scalar>(view, row + 1, query).c2 == expected[row][x]);
      CHECK(lookup_texture<Scalar>(view, row + 1, query).c3 == 0.0f);
    }
  CHECK(lookup_scalar<Scalar>(view, 3, query_at(0, 0)) == 1.0f);
  CHECK(lookup_scalar<Scalar>(view, 4, query_at(0, 0)) == 0.0f);
  CHECK(lookup_scalar_gradient<Scalar>(view, 1, query_at(0.4f, 0.4f)).x == 0.0f);
  CHECK(lanes_agree(view, 1, [](int k) { return random_query(static_cast<std::uint32_t>(k)); }));
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(compile_textures({texture(ThresholdTextureDescription{1.0f, kNan})}), SceneError);
}

TEST_CASE("direction textures: the angle of the vector in two channels, with an offset") {
  const TemporaryFolder folder;
  // East, north, west and south-east.
  constexpr float kDiagonal = 0.35355339f;
  TextureDescription x = image_texture(folder / "x.exr", 4, 1, 1, {1, 0.5f, 0, 0.5f + kDiagonal});
  TextureDescription y = image_texture(folder / "y.exr", 4, 1, 1, {0.5f, 1, 0.5f, 0.5f - kDiagonal});
  for (TextureDescription* t : {&x, &y}) std::get<BitmapDescription>(t->model).filter = TextureFilter::kNearest;
  const DirectionTextureDescription plain{TextureId{0}, TextureId{1}};
  const DirectionTextureDescription rotated{TextureId{0}, TextureId{1}, 0.25f};
  const TextureModel scaled = scaled_texture(rotated, 2, [](const SpectrumInput& color) { return color; });
  const TextureTables textures = compile_textures(
      {x, y, texture(plain), texture(rotated), texture(scaled), texture(DirectionTextureDescription{})});
  const TextureView view = view_of(textures);
  const double angles[4] = {0, 0.5 * std::numbers::pi, std::numbers::pi, -0.25 * std::numbers::pi};
  for (std::uint32_t i = 0; i < 4; ++i) {
    const TextureQuery<Scalar> query = query_at((static_cast<float>(i) + 0.5f) / 4, 0.5f);
    CHECK(double{lookup_scalar<Scalar>(view, 2, query)} == near(angles[i]));
    CHECK(double{lookup_scalar<Scalar>(view, 3, query)} == near(angles[i] + 0.25));
    CHECK(double{lookup_scalar<Scalar>(view, 4, query)} == near(2 * angles[i] + 0.5));
    CHECK(double{lookup_texture<Scalar>(view, 3, query).c1} == near(angles[i] + 0.25));
  }
  CHECK(lookup_scalar<Scalar>(view, 5, query_at(0, 0)) == 0.0f);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(compile_textures({texture(DirectionTextureDescription{1.0f, 0.5f, kNan})}), SceneError);
}

TEST_CASE("uv sets: the input is looked up at the coordinates in the attribute") {
  const TemporaryFolder folder;
  TextureDescription image = image_texture(folder / "a.exr", 2, 2, 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  std::get<BitmapDescription>(image.model).filter = TextureFilter::kNearest;
  // The transform of the image turns (u, v) into (v, u).
  image.to_uv = {0, 1, 0, 1, 0, 0};
  const TextureDescription moved = texture(UvSetTextureDescription{"vertex_uv1", TextureId{0}});
  const TextureDescription product = texture(ProductTextureDescription{TextureId{1}, TextureId{0}});
  const TextureDescription mask = texture(ThresholdTextureDescription{TextureId{1}, 5.5f});
  const TextureDescription twice = texture(UvSetTextureDescription{"vertex_uv1", TextureId{2}});
  const WithUvs scene({image, moved, product, mask, twice});
  const TextureView& view = scene.view;
  CHECK((scene.textures.rows[2].needs & kTextureNeedsMesh) != 0);
  CHECK(scene.textures.rows[0].needs == 0);

  // (0.75, 0.25) of the attribute is the upper left texel of the image, (0.25, 0.75) of the surface the lower right.
  const TextureQuery<Scalar> on_second{{0.25f, 0.75f}, 1, 1, 0.2f, 0.3f};
  CHECK(lookup_texture<Scalar>(view, 1, on_second).c0 == 1.0f);
  CHECK(lookup_texture<Scalar>(view, 0, on_second).c0 == 10.0f);
  CHECK(lookup_texture<Scalar>(view, 2, on_second).c1 == 2.0f * 11.0f);
  CHECK(lookup_scalar<Scalar>(view, 3, on_second) == 0.0f);
  CHECK(lookup_texture<Scalar>(view, 4, on_second).c2 == 3.0f * 3.0f);
  // The attribute is interpolated: (0.6, 0.1) is the upper left texel, (0.1, 0.6) the lower right.
  CHECK(lookup_texture<Scalar>(view, 1, {{0, 0}, 1, 0, 0.6f, 0.1f}).c0 == 1.0f);
  CHECK(lookup_texture<Scalar>(view, 1, {{0, 0}, 1, 0, 0.1f, 0.6f}).c0 == 10.0f);
  CHECK(lookup_scalar<Scalar>(view, 3, {{0, 0}, 1, 0, 0.1f, 0.6f}) == 1.0f);
  // Shape 0 lacks it: (0, 0) is the lower left texel.
  CHECK(lookup_texture<Scalar>(view, 1, {{0.9f, 0.9f}, 0, 0, 0.2f, 0.3f}).c0 == 7.0f);
  CHECK(lookup_scalar_gradient<Scalar>(view, 1, on_second).x == 0.0f);
  for (std::uint32_t row = 1; row < 5; ++row)
    CHECK(lanes_agree(view, row, [&](int k) {
      const auto r = static_cast<std::uint32_t>(k);
      return TextureQuery<Scalar>{{uniform(r, 3), uniform(r, 4)}, r % 2, r % 3, 0.5f * uniform(r, 5), 0.3f};
    }));
  prefetch_texture<Scalar>(view, 4, {0.3f, 0.4f}, {0, 0});
  CHECK_THROWS_WITH_AS(compile_textures({image, texture(UvSetTextureDescription{"uv1", TextureId{0}})}),
                       doctest::Contains("'uv1' is not a mesh attribute"), SceneError);
}

TEST_CASE("uv sets: scenes whose meshes lack the attribute compile") {
  Description d = empty_scene(4, 4);
  const TextureId board = add_checkerboard(d, {1, 1, 1}, {0, 0, 0});
  d.textures.push_back(texture(UvSetTextureDescription{"vertex_uv1", board}));
  DiffuseDescription diffuse;
  diffuse.reflectance = TextureId{1};
  add_rectangle(d, Transform(), add_material(d, diffuse));
  const auto scene = compile_scene(d);
  CHECK(lookup_texture<Scalar>(scene->view().textures, 1, {{0.6f, 0.1f}, 0, 0, 0.2f, 0.2f}).c0 == 1.0f);
}

}  // namespace sheaf::test_texture_composition

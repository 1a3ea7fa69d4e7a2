// Textures at a second set of uv, thresholds and products as parameters of materials: renders against closed forms.
#include "core/image/exr.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_texture_kinds {

namespace {

constexpr double kPiD = 3.14159265358979323846;

TextureId add_texture(Description& d, const TextureModel& model) {
  d.textures.push_back({model, {1, 0, 0, 0, 1, 0}, "", {}});
  return static_cast<TextureId>(d.textures.size() - 1);
}

/// A square of side 2 at z = 0 whose v decreases along y. `vertex_uv1` is (0.25, 0.25) on the side of negative x and
/// (0.75, 0.25) on the other.
void add_floor(Description& d, MaterialId material) {
  Mesh mesh;
  for (const float x : {-1.0f, 0.0f, 0.0f, 1.0f})
    for (const float y : {-1.0f, 1.0f}) {
      mesh.positions.push_back({x, y, 0});
      mesh.uvs.push_back({0.5f + 0.5f * x, 0.5f - 0.5f * y});
    }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 6, 7}, {4, 7, 5}};
  Mesh::Attribute uv1{"vertex_uv1", 3, {}};
  for (int i = 0; i < 8; ++i) uv1.values.insert(uv1.values.end(), {i < 4 ? 0.25f : 0.75f, 0.25f, 0});
  mesh.attributes.push_back(uv1);
  add_shape(d, mesh, Transform(), material);
}

/// The camera sees the point (x, 0, 0).
Description scene_at(float x) {
  Description d = empty_scene(8, 8);
  d.sampler.sample_count = 16;
  look_at(d, {x, 0.1f, 4}, {x, 0, 0}, {0, 1, 0}, 0.01f);
  return d;
}

double mean_of_green(const Description& d) {
  const Image image = render(*compile_scene(d), {}).film.to_image();
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, 1));
  return sum / static_cast<double>(image.pixel_count());
}

}  // namespace

TEST_CASE("texture kinds: reflectances at a second set of uv, multiplied by a constant") {
  for (const float x : {-0.5f, 0.5f}) {
    Description d = scene_at(x);
    const TextureId board = add_checkerboard(d, {0.2f, 0.4f, 0.6f}, {0.1f, 0.8f, 0.3f});
    const TextureId moved = add_texture(d, UvSetTextureDescription{"vertex_uv1", board});
    DiffuseDescription diffuse;
    diffuse.reflectance = add_texture(d, ProductTextureDescription{SpectrumDescription::rgb(1, 0.5f, 1), moved});
    add_floor(d, add_material(d, diffuse));
    add_constant_light(d, 1);
    d.integrator.strategy = LightStrategy::kBsdfOnly;  // without noise
    CHECK(mean_of_green(d) == near(0.5 * (x < 0 ? 0.4 : 0.8), 1e-4));
  }
}

TEST_CASE("texture kinds: thresholds are opacities, and products are weights of blends") {
  for (const float x : {-0.5f, 0.5f}) {
    Description d = scene_at(x);
    const TextureId board = add_checkerboard(d, {0.3f, 0.3f, 0.3f}, {0.6f, 0.6f, 0.6f});
    const TextureId moved = add_texture(d, UvSetTextureDescription{"vertex_uv1", board});
    const TextureId opaque = add_texture(d, ThresholdTextureDescription{moved, 0.5f});
    add_floor(d, add_material(d, MaskDescription{opaque, add_diffuse(d, 0.25f)}));
    add_constant_light(d, 1);
    d.integrator.strategy = LightStrategy::kBsdfOnly;  // without noise
    CHECK(mean_of_green(d) == near(x < 0 ? 1 : 0.25, 1e-4));

    // The blend under light from a point: its value is the weighted sum without noise from the choice.
    Description blend = scene_at(x);
    blend.textures = d.textures;
    blend.sampler.sample_count = 256;
    const TextureId weight = add_texture(blend, ProductTextureDescription{moved, SpectrumDescription::constant(0.5f)});
    add_floor(blend, add_material(blend, BlendDescription{weight, {add_diffuse(blend, 0), add_diffuse(blend, 1)}}));
    add_point_light(blend, {0, 0, 1000}, 1e6f);
    CHECK(mean_of_green(blend) == near(0.5 * (x < 0 ? 0.3 : 0.6) / kPiD, 1e-3));
  }
}

TEST_CASE("texture kinds: normal maps are scaled, and can follow mirrored uv") {
  const float tilt = 20 * static_cast<float>(kPiD) / 180, scale = 0.5f;
  const Vec3f n{0, std::sin(tilt), std::cos(tilt)};
  const Vec3f light{0, -0.6f, 0.8f};
  for (const bool follows_uv : {false, true}) {
    CAPTURE(follows_uv);
    Description d = scene_at(0.5f);
    // Both squares have the same value, so that only the second set of uv gives the normal.
    const SpectrumDescription up = SpectrumDescription::rgb(0.5f, 0.5f, 1);
    const SpectrumDescription mapped =
        SpectrumDescription::rgb(0.5f * n.x + 0.5f, 0.5f * n.y + 0.5f, 0.5f * n.z + 0.5f);
    const TextureId board = add_texture(d, CheckerboardDescription{up, mapped});
    NormalMapDescription map;
    map.normals = add_texture(d, UvSetTextureDescription{"vertex_uv1", board});
    map.nested = add_diffuse(d, 0.5f);
    map.options.soften_terminator = false;
    map.scale = scale;
    map.follows_uv = follows_uv;
    add_floor(d, add_material(d, map));
    add_point_light(d, light * 1000.0f, 1e6f);
    // v decreases along y, so that the y axis of the map is -y of the world if it follows v.
    const double y = (follows_uv ? -1.0 : 1.0) * double{scale * n.y}, length = std::hypot(y, double{n.z});
    const double cosine = (y * -0.6 + double{n.z} * 0.8) / length;
    CHECK(mean_of_green(d) == near(0.5 / kPiD * cosine, 1e-4));
  }
}

}  // namespace sheaf::test_texture_kinds

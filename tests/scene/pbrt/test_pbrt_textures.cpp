// Composite textures of pbrt, at positions where their formulas give the value.
#include "core/image/exr.h"
#include "core/image/image.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/dialects/pbrt/noise.h"
#include "scene/textures/texture_lookup.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_pbrt_textures {

using namespace test;

namespace {

/// The texture "x" of the given ones, evaluated.
struct Seen {
  TextureTables textures;
  std::uint32_t row = 0;

  explicit Seen(const std::string& text) {
    const TemporaryFolder folder;
    write_pnm(folder / "image.ppm", 2, 1, 3, 255, {255, 255, 255, 0, 0, 0});
    Image white(1, 1, {"Y"});
    white.data = {1};
    write_png(folder / "white.png", white);
    const Description d = read_scene(write_below(
        folder, "scene.pbrt",
        "WorldBegin\n" + text + "\nMaterial \"diffuse\" \"texture reflectance\" \"x\"\nShape \"sphere\"\n"));
    textures = compile_textures(d.textures);
    for (const MaterialDescription& material : d.materials)
      if (const auto* diffuse = std::get_if<DiffuseDescription>(&material.model))
        row = static_cast<std::uint32_t>(std::get<TextureId>(diffuse->reflectance));
  }
  Vec3f at(float u, float v) const {
    TextureView view;
    view.rows = textures.rows.data();
    view.images = textures.images.data();
    const Spectrum4 value = lookup_texture<Scalar>(view, row, {{u, v}, 0, 0, 0, 0});
    const float gray = lookup_scalar<Scalar>(view, row, {{u, v}, 0, 0, 0, 0});
    CHECK(gray == within(0.212639 * value.c0 + 0.715169 * value.c1 + 0.072192 * value.c2, 1e-4));
    return {value.c0, value.c1, value.c2};
  }
};

}  // namespace

TEST_CASE("pbrt textures: a mix combines three textures with individual mappings") {
  const Seen seen(R"(
Texture "weight" "float" "imagemap" "string filename" "image.ppm" "string filter" "point" "string encoding" "linear"
Texture "board" "spectrum" "checkerboard" "rgb tex1" [ 1 0 0 ] "rgb tex2" [ 0 1 0 ] "float vscale" 2 "float uscale" 2
Texture "x" "spectrum" "mix" "texture tex1" "board" "rgb tex2" [ 0.2 0.4 0.6 ] "texture amount" "weight")");
  CHECK(length(seen.at(0.25f, 0.25f) - Vec3f{0.2f, 0.4f, 0.6f}) < 1e-6f);
  CHECK(length(seen.at(0.75f, 0.25f) - Vec3f{0, 1, 0}) < 1e-6f);
  CHECK(length(seen.at(0.75f, 0.75f) - Vec3f{1, 0, 0}) < 1e-6f);
  const Seen quarter(R"(
Texture "p" "spectrum" "imagemap" "string filename" "image.ppm" "string filter" "point" "bool invert" true
Texture "x" "spectrum" "mix" "texture tex1" "p" "rgb tex2" [ 1 0.5 0 ] "float amount" 0.25)");
  CHECK(length(quarter.at(0.75f, 0.5f) - Vec3f{1, 0.875f, 0.75f}) < 1e-6f);
}

TEST_CASE("pbrt textures: textures are multiplied and inverted images are scaled") {
  const Seen seen(R"(
Texture "a" "float" "imagemap" "string filename" "image.ppm" "string filter" "point"
Texture "b" "spectrum" "bilerp" "rgb v00" [ 1 0 0 ] "rgb v10" [ 1 0 0 ] "rgb v01" [ 0 0 2 ] "rgb v11" [ 0 0 2 ]
Texture "x" "spectrum" "scale" "texture tex" "b" "texture scale" "a")");
  CHECK(length(seen.at(0.25f, 0.25f) - Vec3f{0.75f, 0, 0.5f}) < 1e-6f);
  CHECK(length(seen.at(0.75f, 0.25f)) < 1e-6f);
  const Seen inverted(R"(
Texture "p" "spectrum" "imagemap" "string filename" "image.ppm" "string filter" "point" "bool invert" true
Texture "x" "spectrum" "scale" "texture tex" "p" "float scale" 0.5)");
  CHECK(inverted.at(0.75f, 0.5f).x == 0.5f);
}

TEST_CASE("pbrt textures: bilerp is exact in the unit square") {
  const Seen seen(R"(Texture "x" "spectrum" "bilerp" "rgb v00" [ 0.1 0 0 ] "rgb v10" [ 0.5 0 0 ] "rgb v01" [ 0 1 0 ]
  "rgb v11" [ 0 0 0.5 ] "float uscale" 0.5 "float udelta" 0.25)");
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 10; ++j) {
      const float u = 0.1f * static_cast<float>(i), v = 0.1f * static_cast<float>(j), s = 0.5f * u + 0.25f;
      const Vec3f expected{(1 - v) * (0.1f * (1 - s) + 0.5f * s), (1 - s) * v, 0.5f * s * v};
      CHECK(length(seen.at(u, v) - expected) < 1e-5f);
    }
}

TEST_CASE("pbrt textures: dots are placed by noise") {
  const Seen seen(R"(Texture "x" "spectrum" "dots" "rgb inside" [ 1 1 1 ] "rgb outside" [ 0 0 0 ]
  "float uscale" 40 "float vscale" 30)");
  int wrong = 0, inside = 0, counted = 0;
  for (int i = 0; i < 6400; ++i) {
    const auto spread = [&](double step) { return static_cast<float>(step * i - std::floor(step * i)); };
    const float u = spread(0.7548776662466927), v = spread(0.5698402909980532);
    const double s = double{u} * 40, t = double{v} * 30, cell_s = std::floor(s + 0.5), cell_t = std::floor(t + 0.5);
    double distance = 1;
    if (pbrt::noise(cell_s + 0.5, cell_t + 0.5, 0.5) > 0)
      distance = std::hypot(s - cell_s - 0.15 * pbrt::noise(cell_s + 1.5, cell_t + 2.8, 0.5),
                            t - cell_t - 0.15 * pbrt::noise(cell_s + 4.5, cell_t + 9.8, 0.5));
    // Texels are 1/8 as wide as cells.
    const bool is_near_rim = std::fabs(distance - 0.35) < 0.2;
    if (is_near_rim || std::max(std::fabs(s - cell_s), std::fabs(t - cell_t)) > 0.35) continue;
    ++counted;
    inside += distance < 0.35;
    wrong += std::fabs(seen.at(u, v).x - (distance < 0.35 ? 1.0f : 0.0f)) > 0.01f;
  }
  CHECK(wrong == 0);
  CHECK(inside > counted / 50);
}

TEST_CASE("pbrt textures: gamma encodings are decoded") {
  const Seen seen(R"(Texture "x" "spectrum" "imagemap" "string filename" "white.png" "string encoding" "gamma 2"
  "float scale" 0.25)");
  CHECK(seen.at(0.25f, 0.5f).x == near(0.25));
  CHECK(contains(error_of_pbrt_world("Texture \"x\" \"spectrum\" \"imagemap\" \"string encoding\" \"gamma\" "
                                     "\"string filename\" \"scene.pbrt\""),
                 "expected sRGB, linear, or gamma and an exponent"));
}

TEST_CASE("pbrt textures: integer images are sRGB and only PNG files may have another encoding") {
  const TemporaryFolder folder;
  const std::vector<int> gray(8 * 8 * 3, 128);
  write_tga(folder / "p.tga", 8, 8, 3, gray);
  write_tga(folder / "p4.TGA", 1, 1, 4, {128, 128, 128, 7});
  write_bmp(folder / "p.bmp", 8, 8, gray);
  write_pnm(folder / "p.ppm", 8, 8, 3, 255, gray);
  write_pnm(folder / "p.pgm", 1, 1, 1, 255, {128});
  write_pnm(folder / "p16.ppm", 1, 1, 3, 65535, {32896, 32896, 32896});
  write_jpeg(folder / "p.jpg", 248);
  write_hdr(folder / "p.hdr", 8, 8, gray);
  Image exact(1, 1, {"R", "G", "B"});
  exact.data = {0.215861f, 0.215861f, 0.215861f};
  write_png(folder / "p.png", exact);
  std::filesystem::copy_file(folder / "p.png", folder / "upper.PNG");
  const double decoded = 0.21586050, stored = 128.0 / 255, bright = 0.93868573;  // of 128 and of 248
  struct Case {
    const char *file, *encoding;
    double expected;
  };
  for (const Case& c : {Case{"p.tga", "", decoded},
                        {"p.tga", "linear", decoded},
                        {"p.tga", "gamma 2", decoded},
                        {"p4.TGA", "", decoded},
                        {"p.bmp", "", decoded},
                        {"p.bmp", "linear", decoded},
                        {"p.ppm", "", decoded},
                        {"p.pgm", "", decoded},
                        {"p16.ppm", "", decoded},
                        {"p.jpg", "", bright},
                        {"p.jpg", "linear", bright},
                        {"p.hdr", "", 128},
                        {"p.hdr", "sRGB", 128},
                        {"p.png", "", decoded},
                        {"upper.PNG", "", decoded},
                        {"p.png", "linear", stored},
                        {"p.png", "gamma 2", stored * stored}})
    for (const char* kind : {"spectrum", "float"}) {
      CAPTURE(std::string(c.file));
      CAPTURE(std::string(c.encoding));
      CAPTURE(std::string(kind));
      std::string text = std::string("WorldBegin\nTexture \"x\" \"") + kind + "\" \"imagemap\" \"string filename\" \"" +
                         c.file + "\" ";
      if (*c.encoding != 0) text += std::string("\"string encoding\" \"") + c.encoding + "\"";
      const Description d = read_scene(write_below(folder, "scene.pbrt", text + "\n"));
      const TextureTables textures = compile_textures(d.textures);
      TextureView view;
      view.rows = textures.rows.data();
      view.images = textures.images.data();
      CHECK(lookup_scalar<Scalar>(view, 0, {{0.5f, 0.5f}, 0, 0, 0, 0}) == near(c.expected, 1e-3));
      // A note lists encodings without effect.
      const bool told = std::any_of(d.notes.begin(), d.notes.end(),
                                    [](const std::string& note) { return contains(note, "for PNG files only"); });
      const std::string name = c.file;
      CHECK(told == (*c.encoding != 0 && std::string_view(c.encoding) != "sRGB" && !name.ends_with("png")));
    }
}

TEST_CASE("pbrt textures: scalar textures use alpha or the mean of the colors") {
  const TemporaryFolder folder;
  Image image(1, 1, {"R", "G", "B", "A"});
  const auto seen = [&](const std::string& file, float alpha) {
    image.data = {0.2f, 0.4f, 0.9f, alpha};
    if (file.ends_with("exr"))
      write_exr(folder / file, image, {});
    else
      write_tga(folder / file, 1, 1, 4, {255, 0, 0, static_cast<int>(alpha * 255)});
    const Description d = read_scene(
        write_below(folder, "scene.pbrt",
                    "WorldBegin\nTexture \"x\" \"float\" \"imagemap\" \"string filename\" \"" + file + "\"\n"));
    const TextureTables textures = compile_textures(d.textures);
    TextureView view;
    view.rows = textures.rows.data();
    view.images = textures.images.data();
    return lookup_scalar<Scalar>(view, 0, {{0.5f, 0.5f}, 0, 0, 0, 0});
  };
  CHECK(seen("a.exr", 0.25f) == near(0.25));
  CHECK(seen("b.exr", 1) == near(0.5));  // red, green and blue have equal weight
  CHECK(seen("c.tga", 0.25f) == near(1 / 3.0));
}

TEST_CASE("pbrt textures: normal maps are linear in PNG files and sRGB in others with a note") {
  for (const bool png : {true, false}) {
    const TemporaryFolder folder;
    Image flat(1, 1, {"R", "G", "B"});
    flat.data = {0.5f, 0.5f, 1};
    write_png(folder / "n.png", flat);
    write_tga(folder / "n.tga", 1, 1, 3, {128, 128, 255});
    const Description d =
        read_scene(write_below(folder, "scene.pbrt",
                               std::string("WorldBegin\nMaterial \"diffuse\" \"string normalmap\" \"n.") +
                                   (png ? "png" : "tga") + "\"\nShape \"sphere\"\n"));
    CHECK(std::get<BitmapDescription>(d.textures.at(0).model).raw == png);
    CHECK(d.notes.empty() == png);
  }
}

}  // namespace sheaf::test_pbrt_textures

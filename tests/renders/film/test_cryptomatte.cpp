// Ids of objects and materials, and Cryptomatte as a compositing program decodes it.
#include "kernels/film/cryptomatte.h"
#include "scene/tables/filter.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"

#include <algorithm>
#include <cstring>
#include <map>

namespace sheaf::test_cryptomatte {

namespace {

const AovSet kIds{aov_named("object_id"), aov_named("material_id"), aov_named("cryptomatte_object"),
                  aov_named("cryptomatte_material")};

/// A disk in front of part of a wall.
Description scene_of_two() {
  Description d = empty_scene(16, 16);
  d.sampler.sample_count = 16;
  const MaterialId red = add_diffuse_rgb(d, 0.6f, 0.1f, 0.1f), gray = add_diffuse(d, 0.5f);
  d.materials[0].id = "paint";
  add_rectangle(d, Transform::translate({-4, 0, 6}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({8, 10, 1}),
                gray);
  d.shapes.back().id = "wall";
  add_sphere(d, {0.2f, 0.1f, 4}, 1.7f, red);
  return d;
}

/// Coverage by id, summed over the ranks as a compositing program does.
using Mattes = std::map<std::uint32_t, float>;
Mattes decode(const Image& image, int x, int y, const std::string& layer) {
  Mattes mattes;
  float last = 2;
  for (int i = 0; i < kCryptomatteRanks; ++i) {
    const std::string level = layer + "0" + std::to_string(i / 2) + ".";
    const int id = image.find_channel(level + (i % 2 == 0 ? "r" : "b"));
    const int coverage = image.find_channel(level + (i % 2 == 0 ? "g" : "a"));
    REQUIRE(id >= 0);
    REQUIRE(coverage >= 0);
    const float pixel_coverage = image.at(x, y, coverage);
    CHECK(pixel_coverage <= last);
    last = pixel_coverage;
    std::uint32_t bits;
    const float word = image.at(x, y, id);
    std::memcpy(&bits, &word, sizeof bits);
    CHECK((pixel_coverage > 0) == (bits != 0));
    if (pixel_coverage > 0) mattes[bits] += pixel_coverage;
  }
  return mattes;
}

Image render_image(const Description& d, const RenderOptions& options) {
  return render(*compile_scene(d), options).to_image();
}

}  // namespace

TEST_CASE("cryptomatte: hashes and ids match published ones") {
  CHECK(murmur_hash3_32("") == 0);
  CHECK(murmur_hash3_32("hello") == 0x248bfa47u);
  CHECK(murmur_hash3_32("hello, world") == 0x149bbb7fu);
  CHECK(murmur_hash3_32("The quick brown fox jumps over the lazy dog") == 0x2e4ff723u);
  CHECK(cryptomatte_id("bunny") == 0x13851a76u);
  CHECK(cryptomatte_id("default") == 0x42c9679fu);
  // Hashes that are infinite or denormal floats are changed, as the specification requires.
  CHECK(murmur_hash3_32("name_65") == 0x7fa70068u);
  CHECK(cryptomatte_id("name_65") == 0x7f270068u);
  CHECK(cryptomatte_id("name_241") == 0x808b95c9u);
}

TEST_CASE("cryptomatte: coverage adds up to the visible area of objects with any filter") {
  for (const FilterMode mode : {FilterMode::kWeighted, FilterMode::kImportance})
    for (const auto kind : {PixelFilter::Kind::kBox, PixelFilter::Kind::kGaussian, PixelFilter::Kind::kMitchell}) {
      Description d = scene_of_two();
      d.film.filter.kind = kind;
      d.film.filter_mode = mode;
      RenderOptions options;
      options.aovs = kIds;
      const Image image = render_image(d, options);
      const std::uint32_t wall = cryptomatte_id("wall"), ball = cryptomatte_id("sphere_2");
      bool mixed = false;
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
          Mattes objects = decode(image, x, y, "CryptoObject"), materials = decode(image, x, y, "CryptoMaterial");
          for (const auto& [id, pixel_coverage] : objects) CHECK((id == wall || id == ball));
          CHECK(objects[wall] == materials[cryptomatte_id("material_2")]);
          CHECK(objects[ball] == materials[cryptomatte_id("paint")]);
          CHECK(objects[wall] + objects[ball] < 1.3f);
          mixed = mixed || (objects[wall] > 0.1f && objects[ball] > 0.1f);
          const float number = image.at(x, y, image.find_channel("objectId"));
          const float nothing = 1 - objects[wall] - objects[ball];
          if (objects[wall] > std::max(objects[ball], nothing) + 0.01f) CHECK(number == 1);
          if (objects[ball] > std::max(objects[wall], nothing) + 0.01f) CHECK(number == 2);
          if (nothing > std::max(objects[wall], objects[ball]) + 0.01f) CHECK(number == 0);
        }
      CHECK(mixed);
      CHECK(decode(image, 8, 8, "CryptoObject")[ball] == near(1));
      CHECK(image.at(8, 8, image.find_channel("materialId")) == 1);
      CHECK(image.at(15, 2, image.find_channel("objectId")) == 1);
      CHECK(image.at(0, 2, image.find_channel("objectId")) == 0);
    }
}

TEST_CASE("cryptomatte: samples placed by negative filter lobes reduce the coverage") {
  // A wall fills one side of an edge. Its coverage of a pixel is the integral of the filter up to the edge.
  for (const auto kind : {PixelFilter::Kind::kLanczos, PixelFilter::Kind::kCatmullRom, PixelFilter::Kind::kMitchell}) {
    CAPTURE(static_cast<int>(kind));
    Description d = empty_scene(9, 1);
    d.film.filter.kind = kind;
    d.film.filter_mode = FilterMode::kImportance;
    d.sampler.sample_count = 16384;
    d.film.sample_border = true;
    // The camera's right is at -x, so that the edge is in the middle of the fifth pixel.
    add_rectangle(d,
                  Transform::translate({40, 0, 4}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({40, 40, 1}),
                  add_diffuse(d, 0.5f));
    RenderOptions options;
    options.aovs = kIds;
    const Image image = render_image(d, options);
    double whole = 0;
    std::vector<double> up_to;
    constexpr int kSteps = 2000;
    const double radius = filter_radius(d.film.filter), step = 2 * radius / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      whole += evaluate_filter(d.film.filter, -radius + (i + 0.5) * step) * step;
      up_to.push_back(whole);
    }
    double largest = 0;
    for (int x = 0; x < 9; ++x) {
      // Distance of the edge from the center of the pixel, to the right.
      const double edge = 4.0 - x;
      const int cell = std::clamp(static_cast<int>((edge + radius) / step), 0, kSteps);
      const double expected = cell == 0 ? 0.0 : up_to[static_cast<std::size_t>(cell - 1)] / whole;
      const Mattes mattes = decode(image, x, 0, "CryptoObject");
      double pixel_coverage = 0;
      for (const auto& [id, covered] : mattes) pixel_coverage += double{covered};
      CAPTURE(x);
      // Names with negative coverage are omitted.
      CHECK(pixel_coverage == within(std::max(expected, 0.0), 0.012));
      largest = std::max(largest, expected);
    }
    CHECK(largest > 1.01);
  }
}

TEST_CASE("cryptomatte: the header lists the layers and all names") {
  const auto scene = compile_scene(scene_of_two());
  const auto attributes = cryptomatte_attributes({aov_named("cryptomatte_object")}, scene->names());
  REQUIRE(attributes.size() == 4);
  const std::string key = "cryptomatte/3ae39a5/";
  CHECK(attributes[0] == std::pair{key + "name", std::string("CryptoObject")});
  CHECK(attributes[1] == std::pair{key + "hash", std::string("MurmurHash3_32")});
  CHECK(attributes[2] == std::pair{key + "conversion", std::string("uint32_to_float32")});
  CHECK(attributes[3].first == key + "manifest");
  CHECK(attributes[3].second.starts_with("{\"sphere_2\":\""));
  CHECK(attributes[3].second.find(",\"wall\":\"") != std::string::npos);
  CHECK(cryptomatte_attributes({aov_named("object_id")}, scene->names()).empty());
  SceneNames odd;
  odd.objects = {"a \"b\"\\\n"};
  CHECK(cryptomatte_attributes({aov_named("cryptomatte_object")}, odd)[3].second.starts_with(
      "{\"a \\\"b\\\"\\\\\\u000a\":"));
}

TEST_CASE("layers of all kinds: the bits do not depend on threads or wave size or crop") {
  Description d = scene_of_two();
  add_point_light(d, {1, 2, 0}, 10);
  add_constant_light(d, 0.5f);
  d.sampler.sample_count = 8;
  for (const auto& [mode, color] :
       {std::pair{FilterMode::kWeighted, ColorMode::kRgb}, {FilterMode::kImportance, ColorMode::kSpectral}}) {
    d.film.filter.kind = PixelFilter::Kind::kMitchell;
    d.film.filter_mode = mode;
    CompileOptions compile;
    compile.color = color;
    const auto scene = compile_scene(d, compile);
    RenderOptions options;
    options.aovs = aovs_from_names("all");
    options.light_groups = true;
    options.threads = 1;
    const Image whole = render(*scene, options).to_image();
    for (const int threads : {2, 7})
      for (const int wave : {7, 256, 1600}) {
        options.threads = threads;
        options.wave_size = wave;
        const Image again = render(*scene, options).to_image();
        REQUIRE(again.channels == whole.channels);
        CHECK(std::memcmp(again.data.data(), whole.data.data(), whole.data.size() * sizeof(float)) == 0);
      }
    options.crop = PixelRect{3, 5, 12, 14};
    const Image part = render(*scene, options).to_image();
    const std::size_t row = static_cast<std::size_t>(part.width) * part.channels.size();
    for (int y = 0; y < part.height; ++y)
      CHECK(std::memcmp(&part.data[static_cast<std::size_t>(y) * row],
                        &whole.data[static_cast<std::size_t>((y + 5) * 16 + 3) * whole.channels.size()],
                        row * sizeof(float)) == 0);
  }
}

}  // namespace sheaf::test_cryptomatte

// The base under pbrt's coats: Sheaf's closed form against pbrt's random walk, simulated here.
#include "core/color/color.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/dialects/pbrt/coat.h"
#include "scene/dialects/pbrt/reader.h"
#include "scene/materials/rough_coat.h"
#include "scene/textures/texture_lookup.h"
#include "tests/support/files/image_files.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace sheaf::test_pbrt_coat {

using namespace test;

namespace {

double fresnel(double cosine, double eta) {
  const double cos2 = 1 - (1 - cosine * cosine) / (eta * eta);
  if (cos2 <= 0) return 1;
  const double t = std::sqrt(cos2), s = (cosine - eta * t) / (cosine + eta * t),
               p = (eta * cosine - t) / (eta * cosine + t);
  return 0.5 * (s * s + p * p);
}

struct Layer {
  double thickness;
  int max_depth;
};
struct Estimate {
  double mean, error;
};

/// Light that leaves a smooth coat after scattering at the base, under diffuse illumination: a random walk between both
/// surfaces of an absorbing layer with at most `max_depth` steps.
Estimate walk(double albedo, double eta, const Layer& layer) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform;
  constexpr int kWalks = 20'000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kWalks; ++i) {
    const double outside = std::sqrt(uniform(random));
    double weight = 1 - fresnel(outside, eta), left = 0;
    double cosine = std::sqrt(1 - (1 - outside * outside) / (eta * eta));
    for (int depth = 0; depth < layer.max_depth; ++depth) {
      weight *= std::exp(-layer.thickness / cosine);
      if (depth % 2 == 0) {  // at the base
        weight *= albedo;
        cosine = std::sqrt(1 - uniform(random));
        // Each vertex that may end the walk also connects to the outside, as next-event estimation does.
        left += weight * std::exp(-layer.thickness / cosine) * (1 - fresnel(cosine, 1 / eta));
      } else {
        weight *= fresnel(cosine, 1 / eta);
      }
    }
    sum += left, squares += left * left;
  }
  const double mean = sum / kWalks;
  return {mean, std::sqrt((squares / kWalks - mean * mean) / kWalks)};
}

/// The same by Sheaf's closed form with a base of albedo `b`.
double closed_form(double b, double eta) {
  const double r = double{smooth_coat_internal_reflectance(eta)};
  const double entering = (1 - r) * eta * eta;  // by reciprocity: fraction of diffuse light from outside
  return entering * b * (1 - r) / (1 - b * r);
}

}  // namespace

TEST_CASE("pbrt coats: the base reflects as in the random walk of pbrt") {
  for (const double eta : {1.5, 1.2})
    for (const double albedo : {0.2, 0.8, 1.0})
      for (const Layer& layer : {Layer{0.01, 10}, {0.1, 10}, {0.0, 3}}) {
        CAPTURE(eta);
        CAPTURE(albedo);
        CAPTURE(layer.thickness);
        CAPTURE(layer.max_depth);
        const Estimate expected = walk(albedo, eta, layer);
        const pbrt::LayeredBase base(0, eta, layer.thickness, layer.max_depth);
        // Within 4 standard errors. Averaging the absorption over angles costs up to 1e-3 in thick layers.
        CHECK(std::abs(closed_form(double{base.albedo(static_cast<float>(albedo))}, eta) - expected.mean) <
              4 * expected.error + (0.5e-3 + 0.05 * layer.thickness) * expected.mean);
      }
  // Without losses, the base has the given albedo.
  const pbrt::LayeredBase clear(0.2, 1.5, 0, 2000);
  for (const float a : {0.0f, 0.3f, 1.0f}) CHECK(clear.albedo(a) == near(a, 1e-5));
  CHECK(pbrt::LayeredBase(0, 1.5, 0.01, 0).albedo(0.5f) == 0);
}

TEST_CASE("pbrt coats: internal reflection of rough coats matches the tables of rough plastics") {
  // Without absorption and with a single reflection at a base of albedo 1: b = 1 / (1 + r).
  for (const double alpha : {0.1, 0.3, 0.6}) {
    CAPTURE(alpha);
    const double b = double{pbrt::LayeredBase(alpha, 1.5, 0, 1).albedo(1)};
    const RoughCoat coat = rough_coat(RoughnessDescription::Distribution::kGgx, alpha, 1.5);
    CHECK(1 / b - 1 == near(double{coat.internal_reflectance}, 0.01));
  }
}

TEST_CASE("pbrt coats: albedos of byte images from a table are those of their values") {
  const TemporaryFolder folder;
  std::vector<int> values(3 * 256);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<int>(i / 3);
  write_pnm(folder / "a.ppm", 16, 16, 3, 255, values);
  const pbrt::LayeredBase base(0, 1.5, 0.01, 10);
  for (const bool raw : {false, true}) {
    BitmapDescription bitmap;
    bitmap.file = folder / "a.ppm";
    bitmap.raw = raw;
    bitmap.change = {0.9f, true, 1.5f};
    const std::shared_ptr<const Image> by_table = pbrt::base_image(bitmap, base);
    bitmap.made = std::make_shared<Image>(pbrt::read_linear_image(bitmap.file, raw, {}));
    REQUIRE(by_table != nullptr);
    CHECK(by_table->data == pbrt::base_image(bitmap, base)->data);
    const float byte = 100.0f / 255;
    CHECK(bitmap.made->data[300] == (raw ? byte : srgb_to_linear(byte)));
  }
}

TEST_CASE("pbrt coats: constants and colors and textures of the base are darkened equally") {
  const pbrt::LayeredBase base(0, 1.5, 0.01, 10);
  const auto reflectance = [](const std::string& world) {
    const TemporaryFolder folder;
    write_pnm(folder / "grey.pgm", 1, 1, 1, 255, {188});
    write_pnm(folder / "colour.ppm", 1, 1, 3, 255, {188, 255, 0});
    const Description d =
        read_scene(write_below(folder, "scene.pbrt", "WorldBegin\n" + world + "\nShape \"sphere\"\n"));
    for (const MaterialDescription& material : d.materials)
      if (const auto* plastic = std::get_if<PlasticDescription>(&material.model)) {
        CHECK(plastic->nonlinear);
        const auto* id = std::get_if<TextureId>(&plastic->diffuse_reflectance);
        if (id == nullptr) {
          const auto& value = std::get<SpectrumDescription>(plastic->diffuse_reflectance).value;
          const auto* gray = std::get_if<SpectrumDescription::Constant>(&value);
          return gray != nullptr ? Vec3f{gray->value, gray->value, gray->value}
                                 : std::get<SpectrumDescription::Rgb>(value).value;
        }
        const TextureTables textures = compile_textures(d.textures);
        TextureView view;
        view.rows = textures.rows.data();
        view.images = textures.images.data();
        const Spectrum4 seen =
            lookup_texture<Scalar>(view, static_cast<std::uint32_t>(*id), {{0.5f, 0.5f}, 0, 0, 0, 0});
        return Vec3f{seen.c0, seen.c1, seen.c2};
      }
    return Vec3f{};
  };
  const auto is = [](Vec3f found, float x, float y, float z) { return length(found - Vec3f{x, y, z}) < 1e-4f; };
  const float half = base.albedo(0.5f), one = base.albedo(1), dark = base.albedo(0.502887f);
  CHECK(half < 0.49f);
  CHECK(is(reflectance("Material \"coateddiffuse\""), half, half, half));
  CHECK(is(reflectance("Material \"coateddiffuse\" \"rgb reflectance\" [ 0.5 1 0 ]"), half, one, 0));
  const std::string texture = "Texture \"x\" \"spectrum\" ",
                    material = "\nMaterial \"coateddiffuse\" \"texture reflectance\" \"x\"";
  CHECK(is(reflectance(texture + "\"imagemap\" \"string filename\" \"grey.pgm\"" + material), dark, dark, dark));
  CHECK(is(reflectance(texture + "\"imagemap\" \"string filename\" \"colour.ppm\"" + material), dark, one, 0));
  const float twice = base.albedo(0.251444f);
  CHECK(is(reflectance(texture + "\"imagemap\" \"float scale\" 0.5 \"string filename\" \"grey.pgm\"" + material), twice,
           twice, twice));
  const float inverse = base.albedo(1 - 0.502887f);
  CHECK(is(reflectance(texture + "\"imagemap\" \"bool invert\" true \"string filename\" \"grey.pgm\"" + material),
           inverse, inverse, inverse));
  CHECK(is(reflectance(texture + "\"checkerboard\" \"rgb tex1\" [ 0.5 1 0 ] \"rgb tex2\" [ 0.5 1 0 ]" + material), half,
           one, 0));
  // Parameters of the layer.
  const float thick = pbrt::LayeredBase(0, 1.3, 0.5, 4).albedo(0.5f);
  CHECK(is(reflectance("Material \"coateddiffuse\" \"float eta\" 1.3 \"float thickness\" 0.5 \"integer maxdepth\" 4"),
           thick, thick, thick));
  const float rough = pbrt::LayeredBase(0.5, 1.5, 0.01, 10).albedo(0.5f);
  CHECK(is(reflectance("Material \"coateddiffuse\" \"float roughness\" 0.25"), rough, rough, rough));
}

}  // namespace sheaf::test_pbrt_coat

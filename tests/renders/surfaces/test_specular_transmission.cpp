// KHR_materials_specular on surfaces that transmit light, and clearcoats over emission.
#include "kernels/bsdf/specular_scale.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/instancing_testing.h"
#include "tests/support/light_tracing_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_specular_transmission {

using namespace test;
using nlohmann::json;

namespace {

/// Means of red, green and blue.
std::array<double, 3> means_of(const Description& d, ColorMode color = ColorMode::kRgb) {
  CompileOptions options;
  options.color = color;
  const Image image = render(*compile_scene(d, options), {}).film.to_image();
  std::array<double, 3> means{};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c)
        means[static_cast<std::size_t>(c)] += static_cast<double>(image.at(x, y, c)) / (image.width * image.height);
  return means;
}

/// A square of glTF at z = 0 with the material, seen from +z at an angle to its normal in degrees.
Description square(const json& material, double angle) {
  GltfBuilder gltf;
  json& primitive = gltf.add_mesh({{"POSITION", gltf.add<float>({-9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0}, "VEC3")},
                                   {"TEXCOORD_0", gltf.add<float>({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2")}});
  primitive["indices"] = gltf.add<std::uint16_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  primitive["material"] = 0;
  gltf.json["nodes"] = {{{"mesh", 0}}};
  gltf.json["materials"] = json::array({material});
  const TemporaryFolder folder;
  Description d = read_scene(write_below(folder, "model.gltf", gltf.text()), {});
  const ShapeDescription shape = d.shapes.front();
  d.shapes = {shape};
  d.lights.clear();
  d.film.width = d.film.height = 4;
  d.sampler.sample_count = 256;
  const auto radians = static_cast<float>(angle * 3.14159265358979 / 180);
  look_at(d, {5 * std::sin(radians), 0, 5 * std::cos(radians)}, {0, 0, 0}, {0, 1, 0}, 0.01f);
  return d;
}

/// A pane or the front of a volume before a white environment behind it.
json transmitting(double specular, const json& color, bool is_volume, double roughness = 0) {
  json material = {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", roughness}}},
                   {"extensions",
                    {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                     {"KHR_materials_specular", {{"specularFactor", specular}, {"specularColorFactor", color}}}}}};
  if (is_volume) material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
  return material;
}

/// The radiance behind the surface is 1, that in front of it 0.
std::array<double, 3> transmitted(const json& material, double angle, ColorMode color = ColorMode::kRgb) {
  Description d = square(material, angle);
  add_area_light_rectangle(d, Transform::translate({0, 0, -1}) * Transform::scale({200, 200, 1}), 1);
  return means_of(d, color);
}

double fresnel(double angle) {
  return static_cast<double>(
      fresnel_dielectric<Scalar>(static_cast<float>(std::cos(angle * 3.14159265358979 / 180)), 1.5f).reflectance);
}

}  // namespace

TEST_CASE("specular transmission: panes transmit what the scaled reflectance leaves") {
  const json white = {1, 1, 1};
  for (const double angle : {0.0, 60.0}) {
    CAPTURE(angle);
    const double once = fresnel(angle);
    for (const double specular : {0.0, 0.5, 1.0}) {
      CAPTURE(specular);
      const double r = specular * once;
      for (const double found : transmitted(transmitting(specular, white, false), angle))
        CHECK(found == near((1 - r) / (1 + r), 0.01));
    }
    // The color scales the reflectance at normal incidence only
    const double normal = 0.04, grazing = once + (0 - normal) * (1 - once) / (1 - normal);
    const auto tinted = transmitted(transmitting(1, {0, 1, 1}, false), angle);
    CHECK(tinted[0] == near((1 - grazing) / (1 + grazing), 0.01));
    CHECK(tinted[1] == near((1 - once) / (1 + once), 0.01));
  }
}

TEST_CASE("specular transmission: volumes without reflection transmit everything") {
  // Radiance is scaled by the squared index inside: 1 / 2.25 is seen from outside.
  const json white = {1, 1, 1};
  for (const double specular : {0.0, 1.0}) {
    CAPTURE(specular);
    for (const double found : transmitted(transmitting(specular, white, true), 30))
      CHECK(found == near((1 - specular * fresnel(30)) / 2.25, 0.01));
  }
  json dispersive = transmitting(0, white, true);
  dispersive["extensions"]["KHR_materials_dispersion"] = {{"dispersion", 0.5}};
  CHECK(transmitted(dispersive, 0, ColorMode::kSpectral)[1] == near(1 / 2.25, 0.1));  // only one wavelength arrives
  // A rough one: white light from all sides comes back but for what is lost between the facets
  for (const double specular : {0.0, 1.0}) {
    Description d = square(transmitting(specular, white, true, 0.3), 20);
    add_constant_light(d, 1);
    CHECK(means_of(d)[1] == near(specular * 0.04 + (1 - specular * 0.04) / 2.25, 0.03));
  }
}

TEST_CASE("specular transmission: factors of 1 leave the reflectance as it is") {
  for (const float cosine : {0.05f, 0.3f, 0.9f, -0.9f, -0.5f}) {
    const float plain = fresnel_dielectric<Scalar>(cosine, 1.5f).reflectance;
    CHECK(scaled_reflectance(plain, 1.5f, 1.0f, 1.0f) == plain);
    const SpecularChoice<Scalar> choice(plain, 1.5f, 1, Spectrum4(1.0f));
    CHECK(choice.probability == plain);
    CHECK(choice.weight(true).c1 == (plain > 0 ? 1.0f : 0.0f));
  }
  // Total internal reflection remains
  CHECK(scaled_reflectance(1.0f, 1.5f, 0.0f, 0.0f) == 1.0f);
}

// Clearcoats over emission

namespace {

json coated(double coat) {
  return {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
          {"emissiveFactor", {1, 1, 1}},
          {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatFactor", coat}}}}}};
}

double schlick(double cosine) { return 0.04 + 0.96 * std::pow(1 - cosine, 5); }

/// A floor under a lamp with a coat of strength 1, seen near the border of the lamp. `textured`: strength by a texture.
Description coated_lamp(bool textured, int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, {0, -4, 0.5f}, {2, 0, 0});
  d.integrator.max_depth = 2;
  add_rectangle(d, Transform::scale({5, 5, 1}), add_diffuse(d, 0.5f));
  ShapeDescription& lamp =
      add_area_light_rectangle(d, Transform::translate({0, 0, 0.6f}) * Transform::rotate({1, 0, 0}, 180), 3);
  lamp.emission_coat = 1.0f;
  if (!textured) return d;
  TextureDescription strength;
  strength.model = CheckerboardDescription{SpectrumDescription::constant(1), SpectrumDescription::constant(0.2f)};
  d.textures.push_back(std::move(strength));
  lamp.emission_coat = static_cast<TextureId>(d.textures.size() - 1);
  return d;
}

}  // namespace

TEST_CASE("coated emission: what is seen depends on the angle") {
  for (const double coat : {0.0, 0.5, 1.0})
    for (const double angle : {0.0, 60.0, 75.0}) {
      CAPTURE(coat);
      CAPTURE(angle);
      const double cosine = std::cos(angle * 3.14159265358979 / 180);
      CHECK(means_of(square(coated(coat), angle))[0] == near(1 - coat * schlick(cosine), 2e-3));
    }
}

TEST_CASE("coated emission: light and BSDF sampling and light tracing agree") {
  const double level = significance_of_each(30);
  for (const bool textured : {false, true}) {
    CAPTURE(textured);
    check_strategies_agree(coated_lamp(textured, 24), level);
    Description seen = coated_lamp(textured, 24);
    seen.film.width = seen.film.height = 12;
    look_at(seen, {0, -5, 2}, {0.5f, 0, 0.3f}, {0, 0, 1}, 45);
    check_light_tracing_agrees(seen);
  }
  // A floor that is lit at grazing angles only becomes darker by more than the mean of the coat
  Description bare = coated_lamp(false, 24);
  bare.shapes.back().emission_coat = 0.0f;
  CHECK(pixel_means(coated_lamp(false, 24))[1].mean() < 0.9 * pixel_means(bare)[1].mean());
}

TEST_CASE("coated emission: lamps of all kinds that move and stretch") {
  const double level = significance_of_each(30);
  Description ball = coated_lamp(false, 24);
  ball.shapes.back().geometry = SphereShape{};
  ball.shapes.back().to_world = Transform::translate({0, 0, 0.8f}) * Transform::scale({0.7f, 0.7f, 0.7f});
  check_strategies_agree(ball, level);
  for (const bool textured : {false, true}) {
    Description moving = coated_lamp(textured, 24);
    const Transform there = moving.shapes.back().to_world;
    const Transform rotated = Transform::translate({0.4f, 0.2f, 0.3f}) * Transform::rotate({0, 1, 0}, -70) * shear();
    move(moving, moving.shapes.back(), {{0, there}, {1, rotated * there * Transform::scale({0.4f, 0.6f, 1})}});
    expose(moving, 0, 1);
    // Far from the lamp, light leaves it at grazing angles first, and along its normal last
    look_at_point(moving, {4.5f, -4, 0.5f}, {4.5f, 0, 0});
    check_strategies_agree(moving, level);
    moving.film.width = moving.film.height = 12;
    look_at(moving, {0, -5, 2}, {0.5f, 0, 0.3f}, {0, 0, 1}, 45);
    check_light_tracing_agrees(moving);
  }
}

}  // namespace sheaf::test_specular_transmission

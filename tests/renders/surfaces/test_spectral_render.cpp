// Renders in spectral mode: against RGB mode where both must agree, white furnaces, and a prism against Snell's law.
#include "core/color/color.h"
#include "core/color/uplift.h"
#include "core/io/error.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/data/glasses.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace sheaf::test_spectral_render {

namespace {

constexpr double kPiD = 3.14159265358979323846;
const CompileOptions kSpectralOptions{false, ColorMode::kSpectral};

Image render_image(const Description& d, ColorMode color, std::uint32_t spp, std::uint32_t seed) {
  RenderOptions options;
  options.samples_per_pixel = spp;
  options.seed = seed;
  return render(*compile_scene(d, {false, color}), options).film.to_image();
}

/// Means of R, G and B over an image.
std::array<double, 3> means_of(const Image& image) {
  std::array<double, 3> sum{};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += image.at(x, y, c);
  for (double& s : sum) s /= static_cast<double>(image.pixel_count());
  return sum;
}

/// Every kind of closure without color, and lights of white or tinted spectra.
Description gray_scene() {
  Description d = empty_scene(8, 8);
  add_rectangle(d,
                Transform::translate({0, -1.5f, 4}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}),
                add_diffuse(d, 0.7f));
  ConductorDescription metal;
  metal.ior = {SpectrumDescription::constant(0.5f), SpectrumDescription::constant(3)};
  add_sphere(d, {-0.7f, -0.5f, 4}, 0.8f, add_material(d, metal));
  add_sphere(d, {1, -0.6f, 3}, 0.7f, add_glass(d));
  PlasticDescription plastic;
  plastic.roughness = RoughnessDescription{};
  add_shape(d, CylinderShape{}, Transform::translate({1.8f, -0.5f, 4}) * Transform::scale({0.4f, 0.7f, 1}),
            add_material(d, plastic));
  add_area_light_rectangle(d, Transform::translate({0, 1.8f, 4}) * Transform::rotate({1, 0, 0}, 90), 3);
  add_point_light(d, {0, 0.5f, 2}, 2);
  add_constant_light(d, 0.5f);
  return d;
}

/// Equal power at every wavelength: illuminant E with Y = `value`.
SpectrumDescription equal_energy(float value) { return {SpectrumDescription::Table{{360, 830}, {value, value}}}; }

}  // namespace

TEST_CASE("spectral: scenes without color have the channel means of RGB mode") {
  const Description d = gray_scene();
  constexpr int kBatches = 24;
  MeanVariance of_mode[2][3];
  for (std::uint32_t batch = 0; batch < kBatches; ++batch)
    for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
      const auto mean = means_of(render_image(d, color, 64, batch + 1));
      for (std::size_t c = 0; c < 3; ++c) of_mode[static_cast<int>(color)][c].add(mean[c]);
    }
  for (int c = 0; c < 3; ++c) {
    const MeanVariance &rgb = of_mode[0][c], &spectral = of_mode[1][c];
    CAPTURE(c);
    INFO("rgb " << rgb.mean() << ", spectral " << spectral.mean());
    const double error = std::sqrt((rgb.variance() + spectral.variance()) / kBatches);
    CHECK(student_t_p_value((spectral.mean() - rgb.mean()) / error, kBatches - 1) > significance_of_each(3));
    CHECK(error < 0.01 * rgb.mean());
  }
}

TEST_CASE("spectral: a color under daylight is reproduced") {
  // One bounce in a constant environment: the pixel shows the reflectance.
  for (const Vec3f rgb : {Vec3f{0.8f, 0.3f, 0.1f}, Vec3f{0.1f, 0.6f, 0.3f}, Vec3f{0.2f, 0.25f, 0.7f}}) {
    Description d = empty_scene(8, 8);
    add_sphere(d, {0, 0, 4}, 3, add_diffuse_rgb(d, rgb.x, rgb.y, rgb.z));
    d.integrator.max_depth = 2;
    d.camera.fov = 20;
    add_constant_light(d, 1);
    MeanVariance channel[3];
    for (std::uint32_t batch = 0; batch < 16; ++batch) {
      const auto mean = means_of(render_image(d, ColorMode::kSpectral, 256, batch + 1));
      for (std::size_t c = 0; c < 3; ++c) channel[c].add(mean[c]);
    }
    CHECK(channel[0].mean() == near(rgb.x, 0.01));
    CHECK(channel[1].mean() == near(rgb.y, 0.01));
    CHECK(channel[2].mean() == near(rgb.z, 0.01));
  }
}

TEST_CASE("spectral: a white furnace stays white under D65 and under equal energy") {
  for (const bool daylight : {true, false}) {
    Description d = empty_scene(16, 16);
    add_sphere(d, {0, 0, 4}, 1, add_diffuse(d, 1));
    d.lights.push_back({ConstantLightDescription{daylight ? SpectrumDescription::constant(1) : equal_energy(1)}, {}});
    d.integrator.max_depth = 20;
    const auto mean = means_of(render_image(d, ColorMode::kSpectral, 1024, 3));
    const Vec3f xyz =
        rec709_to_xyz({static_cast<float>(mean[0]), static_cast<float>(mean[1]), static_cast<float>(mean[2])});
    const float sum = xyz.x + xyz.y + xyz.z;
    CAPTURE(daylight);
    CHECK(xyz.y == near(1, 0.005));
    CHECK(std::fabs(xyz.x / sum - (daylight ? 0.3127f : 1.0f / 3)) < 0.002f);
    CHECK(std::fabs(xyz.y / sum - (daylight ? 0.3290f : 1.0f / 3)) < 0.002f);
  }
}

TEST_CASE("spectral: images do not depend on threads or wave size") {
  Description d = mixed_scene(24, 24);
  DielectricDescription glass;
  glass.int_dispersion = *find_dispersion("sf11");
  add_sphere(d, {0, 0.4f, 3}, 0.4f, add_material(d, glass));
  const auto scene = compile_scene(d, kSpectralOptions);
  std::vector<float> first;
  for (const auto& [threads, wave_size] : {std::pair{1, 256}, std::pair{2, 1024}, std::pair{3, 1600}}) {
    RenderOptions options;
    options.samples_per_pixel = 16;
    options.threads = threads;
    options.wave_size = wave_size;
    const RenderResult result = render(*scene, options);
    CHECK(result.report.stats.dropped.samples == 0);
    const Image image = result.film.to_image();
    if (first.empty()) first = image.data;
    CHECK(image.data == first);
  }
}

namespace {

/// A prism of refracting angle 60 degrees with a vertical edge at the origin. It deviates rays along +z towards -x and
/// is open at its base.
Mesh prism_mesh(float size) {
  Mesh mesh;
  const float half = 0.5f * size, depth = half / std::tan(static_cast<float>(kPiD) / 6);
  for (const float y : {-size, size})
    for (const Vec3f corner :
         {Vec3f{0.5f * depth, y, 0}, Vec3f{-0.5f * depth, y, -half}, Vec3f{-0.5f * depth, y, half}})
      mesh.positions.push_back(corner);
  // Front (towards -z), back (towards +z), base and the two ends, with outward normals.
  mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {0, 3, 5}, {0, 5, 2}, {1, 2, 5}, {1, 5, 4}, {0, 2, 1}, {3, 4, 5}};
  return mesh;
}

/// Direction in the plane y = 0, as an angle from +z towards +x, in which a ray at angle `in` leaves the prism of index
/// `n`, by Snell's law at front and back.
double angle_behind_prism(double in, double n) {
  // Outward normals of front and back, as angles: the front faces 30 degrees from -z towards +x.
  const double front = kPiD / 6;  // of the inward normal of the front, from +z towards -x
  // Angle of incidence, positive towards +x of the inward normal.
  const double i1 = in + front, r1 = std::asin(std::sin(i1) / n);
  const double inside = r1 - front;
  // The outward normal of the back points from +z towards +x by 30 degrees.
  const double i2 = inside - front, r2 = std::asin(n * std::sin(i2));
  return r2 + front;
}

}  // namespace

TEST_CASE("spectral: a prism deviates 450 and 550 and 650 nm by the laws of Snell and Sellmeier" *
          doctest::test_suite("slow")) {
  const Dispersion& sf11 = *find_dispersion("sf11");
  constexpr int kColumns = 240;
  constexpr float kFov = 24;
  constexpr double kFar = 1000;
  for (const double wavelength : {450.0, 550.0, 650.0}) {
    const double n = double(ior<Scalar>(sf11, static_cast<float>(wavelength)));
    // Near minimum deviation, a ray crosses the prism parallel to its base.
    const double straight = std::asin(n * std::sin(kPiD / 6)) - kPiD / 6;
    Description d = empty_scene(kColumns, 1);
    d.integrator.max_depth = 4;
    // The camera is close to the prism and looks along the ray of 550 nm that passes symmetrically.
    const double middle = std::asin(double(ior<Scalar>(sf11, 550.0f)) * 0.5) - kPiD / 6;
    const Vec3f origin{static_cast<float>(-4 * std::sin(middle)), 0, static_cast<float>(-4 * std::cos(middle))};
    look_at(d, origin, {0, 0, 0}, {0, 1, 0}, kFov);
    DielectricDescription glass;
    glass.int_ior = 1.7f;
    glass.ext_ior = 1;
    glass.int_dispersion = sf11;
    add_shape(d, prism_mesh(4), Transform(), add_material(d, glass));
    // A distant strip that emits this wavelength only, in the direction in which the symmetric ray leaves.
    const double out = angle_behind_prism(straight, n);
    const Vec3f there{static_cast<float>(kFar * std::sin(out)), 0, static_cast<float>(kFar * std::cos(out))};
    ShapeDescription& strip = add_rectangle(
        d, Transform::look_at(there, {0, 0, 0}, {0, 1, 0}) * Transform::scale({2, 300, 1}), add_diffuse(d, 0));
    const auto lambda = static_cast<float>(wavelength);
    strip.radiance = SpectrumDescription{
        SpectrumDescription::Table{{lambda - 2, lambda - 1, lambda + 1, lambda + 2}, {0, 1000, 1000, 0}}};

    const Image image = render_image(d, ColorMode::kSpectral, 4096, 1);
    double sum = 0, weighted = 0;
    for (int x = 0; x < kColumns; ++x) {
      const double brightness =
          std::fabs(image.at(x, 0, 0)) + std::fabs(image.at(x, 0, 1)) + std::fabs(image.at(x, 0, 2));
      sum += brightness;
      weighted += brightness * (x + 0.5);
    }
    REQUIRE(sum > 0);
    // Column whose rays leave the prism in the direction of the strip. The camera's x axis points to the left of the
    // image.
    const double half_width = std::tan(0.5 * kFov * kPiD / 180);
    double expected = -1, least = 1;
    for (double x = 0; x < kColumns; x += 0.01) {
      const double across = (2 * x / kColumns - 1) * half_width;
      const double in = middle - std::atan(across);
      const double left = std::fabs(angle_behind_prism(in, n) - out);
      if (left < least) least = left, expected = x;
    }
    CAPTURE(wavelength);
    INFO("found at column " << weighted / sum << ", expected at " << expected);
    CHECK(std::fabs(weighted / sum - expected) < 1);
  }
}

TEST_CASE("spectral: colors of constants and textures match RGB mode" * doctest::test_suite("slow")) {
  // One bounce under a constant light: the mean over the sphere is a weighted mean of the lobes.
  const auto scene = [](const auto& model) {
    Description d = empty_scene(8, 8);
    add_sphere(d, {0, 0, 4}, 1, add_material(d, model));
    d.camera.fov = 30;
    d.integrator.max_depth = 2;
    add_constant_light(d, 1);
    return d;
  };
  const SpectrumDescription red = SpectrumDescription::rgb(0.7f, 0.15f, 0.05f);
  PrincipledDescription principled;
  principled.base_color = red;
  principled.spec_tint = principled.sheen_tint = 1.0f;
  principled.sheen = 1.0f, principled.eta = 2.5f;
  PrincipledThinDescription thin;
  thin.base_color = red;
  thin.spec_tint = thin.sheen_tint = thin.sheen = 1.0f;
  thin.spec_trans = 0.5f, thin.eta = 2.5f;
  DisneyDescription disney;
  disney.base_color = red;
  disney.specular_tint = disney.sheen_tint = disney.sheen = disney.specular = 1.0f;
  std::vector<Description> scenes{scene(principled), scene(thin), scene(disney)};
  for (Description d : std::vector<Description>(scenes)) {
    TextureDescription board;
    board.model = CheckerboardDescription{red, red};
    d.textures.push_back(board);
    std::visit(
        [](auto& model) {
          if constexpr (requires { model.base_color; }) model.base_color = TextureId{0};
        },
        d.materials.back().model);
    scenes.push_back(std::move(d));
  }
  constexpr int kBatches = 16;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    MeanVariance of_mode[2][3];
    for (std::uint32_t batch = 0; batch < kBatches; ++batch)
      for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
        const auto mean = means_of(render_image(scenes[i], color, 256, batch + 1));
        for (std::size_t c = 0; c < 3; ++c) of_mode[static_cast<int>(color)][c].add(mean[c]);
      }
    for (int c = 0; c < 3; ++c) {
      const MeanVariance &rgb = of_mode[0][c], &spectral = of_mode[1][c];
      CAPTURE(i);
      CAPTURE(c);
      INFO("rgb " << rgb.mean() << ", spectral " << spectral.mean());
      // Upsampled constants are within 1e-4 of their color and textures within 0.005. Hue amplifies these errors.
      const double allowed = i < 3 ? 0.002 : 0.01;
      const double error = std::sqrt((rgb.variance() + spectral.variance()) / kBatches);
      const double difference = std::max(0.0, std::fabs(spectral.mean() - rgb.mean()) - allowed);
      CHECK(student_t_p_value(difference / error, kBatches - 1) > significance_of_each(18));
      CHECK(error < 0.01 * rgb.mean());
    }
  }
}

TEST_CASE("spectral: spectral bins add up to the image for any number of threads") {
  Description d = mixed_scene(12, 12);
  DielectricDescription glass;
  glass.int_dispersion = *find_dispersion("sf11");
  add_sphere(d, {0, 0.4f, 3}, 0.4f, add_material(d, glass));
  const auto scene = compile_scene(d, kSpectralOptions);
  RenderOptions options;
  options.samples_per_pixel = 64;
  options.spectral_bins = kMaxSpectralBins;
  const Image image = render(*scene, options).film.to_image();
  const int first = image.find_channel("sampleCount") + 1;
  const double width = 470.0 / kMaxSpectralBins;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double sum[3] = {}, size = 0;
      for (int bin = 0; bin < kMaxSpectralBins; ++bin) {
        const Vec3f response = xyz_to_rec709(cie_1931_xyz(static_cast<float>(360 + (bin + 0.5) * width)));
        const double power = static_cast<double>(image.at(x, y, first + bin)) * width / 106.857;  // over that of y
        sum[0] += power * static_cast<double>(response.x);
        sum[1] += power * static_cast<double>(response.y);
        sum[2] += power * static_cast<double>(response.z);
        size += power * static_cast<double>(length(response));
      }
      // Within a bin, the response changes by at most 2 % of its maximum.
      for (int c = 0; c < 3; ++c)
        CHECK(std::fabs(sum[c] - static_cast<double>(image.at(x, y, c))) < 0.01 * size + 1e-4);
    }

  options.threads = 3, options.wave_size = 256;
  CHECK(render(*scene, options).film.to_image().data == image.data);
  options.spectral_bins = kMaxSpectralBins + 1;
  CHECK_THROWS_AS(render(*scene, options), Error);
  options.spectral_bins = 8;
  CHECK_THROWS_AS(render(*compile_scene(d, CompileOptions{}), options), Error);
}

}  // namespace sheaf::test_spectral_render

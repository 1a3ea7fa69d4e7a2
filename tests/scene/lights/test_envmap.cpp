// Environment maps: texel positions, sampling against pdf, pdf against radiance, spectral mode, and degenerate images.
#include "kernels/lights/envmap.h"

#include "core/color/color.h"
#include "core/image/exr.h"
#include "scene/compile/compile.h"
#include "tests/support/chi_square.h"
#include "tests/support/envmap_testing.h"
#include "tests/support/files/image_files.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"
#include "tests/support/spectral_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace sheaf::test_envmap {

using test::envmap_image;
using test::uneven_image;

namespace {

constexpr double kPiD = std::numbers::pi;
constexpr int kTests = 9;  // chi-square tests in this file

/// Direction of a position in the unit square, by the definition in scene/tables/envmap.h.
Vec3f direction_of(double u, double v) {
  const double phi = 2 * kPiD * u, theta = kPiD * v;
  return {static_cast<float>(std::sin(phi) * std::sin(theta)), static_cast<float>(std::cos(theta)),
          static_cast<float>(-std::cos(phi) * std::sin(theta))};
}

Envmap rotated(Envmap map) {
  set_rotation(map, Transform::rotate({1, 2, 3}, 70) * Transform::scale({-2, 2, 2}), {});
  return map;
}

/// More rows and columns than quantiles, with a few bright texels.
EnvmapImage large_image() {
  return envmap_image(2100, 1500, [](std::uint32_t x, std::uint32_t y) {
    if (x >= 400 && x < 406 && y >= 300 && y < 304) return Vec3f{2e4f, 2e4f, 2e4f};
    const float noise = static_cast<float>((x * 2654435761u ^ y * 2246822519u) >> 20 & 0xffu) / 255;
    const float slow = 1 + std::sin(0.01f * static_cast<float>(x)) * std::cos(0.02f * static_cast<float>(y));
    return Vec3f{slow + 0.2f * noise, slow, 0.3f};
  });
}

ChiSquare check_sampling(const Envmap& map) {
  const EnvmapView view = map.view();
  return chi_square_sphere(
      [&](Random4<Scalar> u) -> std::optional<Vec3f> {
        const auto s = sample_envmap<Scalar>(view, u.x, u.y);
        return s.pdf_solid_angle > 0 ? std::optional<Vec3f>(s.direction) : std::nullopt;
      },
      [&](Vec3f w) { return lookup_envmap<Scalar>(view, w).pdf_solid_angle; });
}

/// Integral of the pdf over the unit square: the mean of all cells.
double integral_of(const Envmap& map) {
  double sum = 0;
  for (const EnvmapColumn& column : map.columns) sum += column.density;
  return sum / (double(map.width) * (map.height - 1));
}

}  // namespace

TEST_CASE("environment map: texel centers lie at their documented directions") {
  const EnvmapImage image = uneven_image();
  const Envmap map = make_envmap(image, 2, false);
  for (std::uint32_t j = 0; j < 7; ++j)
    for (std::uint32_t i = 0; i < 11; ++i) {
      const double v = std::clamp(j / 6.0, 1e-5, 1 - 1e-5);  // at a pole the longitude would be lost
      const auto value = lookup_envmap<Scalar>(map.view(), direction_of((i + 0.5) / 11, v)).radiance;
      const float* pixel = &image.rgb[3 * (j * 11 + i)];
      // At the poles, 6e-5 of the next row, which is 0.1 where that of the pole is 0
      const float found[] = {value.c0, value.c1, value.c2};
      for (std::size_t c = 0; c < 3; ++c) CHECK(found[c] == within(2 * pixel[c], 2e-3 * 2 * pixel[c] + 1e-5));
    }
  // Between the last and the first column, and between two rows.
  const auto seam = lookup_envmap<Scalar>(map.view(), direction_of(0, 5.5 / 6)).radiance;
  const float* row = &image.rgb[3 * 5 * 11];
  const float expected = 2 * 0.25f * (row[0] + row[30] + row[33] + row[63]);
  CHECK(seam.c0 == near(expected, 1e-4));
}

TEST_CASE("environment map: directions follow their pdf" * doctest::test_suite("slow")) {
  SUBCASE("untransformed") {
    CHECK(check_sampling(make_envmap(uneven_image(), 1, false)).p_value > significance_of_each(kTests));
  }
  SUBCASE("rotated and mirrored") {
    const ChiSquare result = check_sampling(rotated(make_envmap(uneven_image(), 1, false)));
    CHECK(result.p_value > significance_of_each(kTests));
    CHECK(result.integral == near(1, 2e-3));
  }
  SUBCASE("compensated") {
    const Envmap map = make_envmap(uneven_image(), 1, true);
    CHECK(check_sampling(map).p_value > significance_of_each(kTests));
    CHECK(lookup_envmap<Scalar>(map.view(), direction_of(0.05, 0.4)).pdf_solid_angle == 0);
    CHECK(lookup_envmap<Scalar>(map.view(), direction_of(0.05, 0.4)).radiance.c1 > 0);
  }
  SUBCASE("more rows and columns than quantiles") {
    const ChiSquare result = check_sampling(make_envmap(large_image(), 1, false));
    CHECK(result.p_value > significance_of_each(kTests));
  }
  SUBCASE("one row") {
    const auto p = envmap_image(5, 1, [](std::uint32_t x, std::uint32_t) { return Vec3f{1.0f + x, 1, 1}; });
    CHECK(check_sampling(make_envmap(p, 1, false)).p_value > significance_of_each(kTests));
  }
  SUBCASE("one column") {
    const auto p = envmap_image(1, 5, [](std::uint32_t, std::uint32_t y) { return Vec3f{1, 1.0f + y, 1}; });
    CHECK(check_sampling(make_envmap(p, 1, false)).p_value > significance_of_each(kTests));
  }
  SUBCASE("one pixel") {
    const auto p = envmap_image(1, 1, [](std::uint32_t, std::uint32_t) { return Vec3f{2, 3, 4}; });
    const Envmap map = make_envmap(p, 1, false);
    CHECK(check_sampling(map).p_value > significance_of_each(kTests));
    CHECK(lookup_envmap<Scalar>(map.view(), {1, 0, 0}).radiance.c2 == near(4));
    CHECK(map.mean.y == near(3));
  }
}

TEST_CASE("environment map: the pdf integrates to one and is positive wherever there is radiance") {
  for (const bool bright_pole : {false, true}) {
    EnvmapImage image = uneven_image();
    if (bright_pole) {
      const auto top = [](std::uint32_t, std::uint32_t y) { return y == 0 ? Vec3f{9, 9, 9} : Vec3f{0, 0, 0}; };
      image = envmap_image(6, 4, top);
    }
    const Envmap map = make_envmap(image, 1, false);
    CHECK(integral_of(map) == near(1, 1e-5));
    for (std::uint32_t i = 0; i < 2000; ++i) {
      const auto u = random4<Scalar>(3, i, 0, 0);
      const auto value = lookup_envmap<Scalar>(map.view(), square_to_sphere<Scalar>(u.x, u.y));
      if (value.radiance.c1 > 0) CHECK(value.pdf_solid_angle > 0);
    }
  }
}

TEST_CASE("environment map: radiance is rounded to 11 bits over a range of 2^62") {
  for (const float value : {1.0f, 1.999f, 0.3f, 1e-3f, 7.7e-12f, 2.5e-19f, 0x1.ffffp-3f}) {
    const float back = envmap_value<Scalar>(envmap_code(value)) * 0x1p64f;
    CHECK(std::fabs(double(back) / value - 1) <= 0x1p-11);
  }
  CHECK(envmap_code(0) == 0);
  CHECK(envmap_code(1e-19f) == 0);
  CHECK(envmap_value<Scalar>(envmap_code(5)) * 0x1p64f == near(2, 1e-3));
  // The brightest texel sets the unit. A sun of 2^40 does not affect dark texels.
  for (const float bright : {3e-30f, 1.0f, 1e12f, 1e18f}) {
    const auto p = envmap_image(8, 4, [&](std::uint32_t x, std::uint32_t y) {
      return Vec3f{1, 0.25f, 0} * (x == 2 && y == 1 ? bright : bright * 0x1p-40f);
    });
    const Envmap map = make_envmap(p, 1, false);
    const auto sun = lookup_envmap<Scalar>(map.view(), direction_of(2.5 / 8, 1 / 3.0)).radiance;
    const auto night = lookup_envmap<Scalar>(map.view(), direction_of(6.5 / 8, 2 / 3.0)).radiance;
    CHECK(sun.c0 == near(bright, 2e-3));
    CHECK(night.c1 == near(bright * 0x1p-42f, 2e-3));
    CHECK(night.c2 == 0);
  }
  CHECK_THROWS_AS(make_envmap(envmap_image(kMaxQuantileEntries + 1, 1, [](auto, auto) { return Vec3f{}; }), 1, false),
                  SceneError);
}

TEST_CASE("environment map: rounding of the quantiles adds little variance") {
  const Envmap map = make_envmap(large_image(), 1, false);
  MeanVariance ratio;
  for (std::uint32_t i = 0; i < 100000; ++i) {
    const auto u = random4<Scalar>(9, i, 0, 0);
    const auto s = sample_envmap<Scalar>(map.view(), u.x, u.y);
    ratio.add((0.2126f * s.radiance.c0 + 0.7152f * s.radiance.c1 + 0.0722f * s.radiance.c2) / s.pdf_solid_angle);
  }
  CHECK(ratio.variance() < 0.12 * ratio.mean() * ratio.mean());
}

TEST_CASE("environment map: the radiance of a sample equals the lookup in its direction") {
  const Envmap map = rotated(make_envmap(uneven_image(), 1, false));
  double worst = 0;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const auto u = random4<Scalar>(4, i, 0, 0);
    const auto s = sample_envmap<Scalar>(map.view(), u.x, u.y);
    CHECK(length(s.direction) == near(1, 1e-5));
    const auto value = lookup_envmap<Scalar>(map.view(), s.direction);
    worst = std::max(worst, std::fabs(double(value.pdf_solid_angle) / s.pdf_solid_angle - 1));
    CHECK(value.radiance.c0 == near(s.radiance.c0, 2e-3));
  }
  CHECK(worst < 2e-3);
}

TEST_CASE("environment map: SIMD results equal scalar ones") {
  const Envmap map = rotated(make_envmap(uneven_image(), 1, false));
  for (std::uint32_t i = 0; i < 500; ++i) {
    const auto one = [i](int lane) { return random4<Scalar>(5, i, static_cast<std::uint32_t>(lane), 0); };
    const WideFloat u = wide_floats([&](int lane) { return one(lane).x; });
    const WideFloat v = wide_floats([&](int lane) { return one(lane).y; });
    const auto wide = sample_envmap<Wide>(map.view(), u, v);
    const auto looked_up = lookup_envmap<Wide>(map.view(), wide.direction);
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto s = sample_envmap<Scalar>(map.view(), one(lane).x, one(lane).y);
      CHECK(difference(wide.direction.x[lane], s.direction.x) < 1e-5);
      CHECK(difference(wide.direction.z[lane], s.direction.z) < 1e-5);
      CHECK(difference(wide.pdf_solid_angle[lane], s.pdf_solid_angle) < 1e-4);
      CHECK(difference(wide.radiance.c0[lane], s.radiance.c0) < 1e-4);
      const Vec3f w{wide.direction.x[lane], wide.direction.y[lane], wide.direction.z[lane]};
      const auto value = lookup_envmap<Scalar>(map.view(), w);
      CHECK(difference(looked_up.pdf_solid_angle[lane], value.pdf_solid_angle) < 1e-3);
      CHECK(difference(looked_up.radiance.c2[lane], value.radiance.c2) < 1e-3);
    }
  }
}

namespace {

constexpr ColorMode kSpectral = ColorMode::kSpectral;
const Spectrum4 kSomeWavelengths(430, 510, 590, 670);

Envmap uplifted(Envmap map) {
  uplift_nodes(map);
  return map;
}

/// shape * scale: the spectrum at four wavelengths.
struct ShapeAndScale {
  double shape[4], scale;
};

/// Fitted to the color directly, without the table.
ShapeAndScale fitted(Vec3f rgb) {
  const ScaledSigmoid<Scalar> s = fit_unbounded(rgb);
  const Spectrum4 v = evaluate(s.shape, kSomeWavelengths);
  return {{v.c0, v.c1, v.c2, v.c3}, s.scale};
}

ShapeAndScale gray(double value) { return {{0.5, 0.5, 0.5, 0.5}, 2 * value}; }

/// Two columns of one color each, `a` at u = 1/4 and `b` at u = 3/4.
Envmap two_colors(Vec3f a, Vec3f b) {
  return uplifted(
      make_envmap(envmap_image(2, 2, [&](std::uint32_t x, std::uint32_t) { return x == 0 ? a : b; }), 1, false));
}

}  // namespace

TEST_CASE("environment map: a map of one color has the spectrum of that color") {
  for (const Vec3f rgb : {Vec3f{0.8f, 0.3f, 0.1f}, Vec3f{20, 40, 30}, Vec3f{0.5f, 0.5f, 0.5f}}) {
    const Envmap map =
        uplifted(make_envmap(envmap_image(19, 3, [&](std::uint32_t, std::uint32_t) { return rgb; }), 2, false));
    const Vec3f w = direction_of(0.3, 0.7);
    const auto at = [&](float l) { return lookup_envmap<Scalar, kSpectral>(map.view(), w, Spectrum4(l)).radiance.c0; };
    const Vec3f seen = reflectance_to_rgb(at);
    CHECK(largest_difference(seen, rgb * 2.0f) < 0.005 * max_component(rgb * 2.0f));
    if (rgb.x == rgb.y) CHECK((at(400) == 2 * rgb.x && at(700) == 2 * rgb.x));
  }
}

TEST_CASE("environment map: spectra are interpolated by mixing their shapes and scales") {
  const Vec3f red{4, 1, 1}, blue{0.2f, 0.5f, 9};
  struct Case {
    Vec3f a, b;
    ShapeAndScale of_a, of_b;
  };
  const Case cases[] = {{red, blue, fitted(red), fitted(blue)},
                        {red, {1, 1, 1}, fitted(red), gray(1)},
                        {{30, 30, 30}, blue, gray(30), fitted(blue)},
                        {{4, 4, 4}, {1, 1, 1}, gray(4), gray(1)},
                        {red, {0, 0, 0}, fitted(red), gray(0)}};
  for (const Case& c : cases) {
    const Envmap map = two_colors(c.a, c.b);
    for (const double t : {0.1, 0.25, 0.5, 0.8}) {
      const auto found =
          lookup_envmap<Scalar, kSpectral>(map.view(), direction_of(0.25 + 0.5 * t, 0.4), kSomeWavelengths);
      const float values[] = {found.radiance.c0, found.radiance.c1, found.radiance.c2, found.radiance.c3};
      const double scale = (1 - t) * c.of_a.scale + t * c.of_b.scale;
      for (int k = 0; k < 4; ++k) {
        const double shape = (1 - t) * c.of_a.shape[k] + t * c.of_b.shape[k];
        CHECK(std::fabs(values[k] - scale * shape) < 0.01 * scale);
      }
      const auto plain = lookup_envmap<Scalar>(map.view(), direction_of(0.25 + 0.5 * t, 0.4));
      CHECK(found.pdf_solid_angle == near(plain.pdf_solid_angle, 1e-5));
    }
  }
  // Differs from the spectrum of the mixed color.
  const auto half =
      lookup_envmap<Scalar, kSpectral>(two_colors(red, {1, 1, 1}).view(), direction_of(0.5, 0.4), kSomeWavelengths);
  CHECK(half.radiance.c3 < 0.97f * evaluate(fit_unbounded({2.5f, 1, 1}), kSomeWavelengths).c3);
}

TEST_CASE("environment map: the spectrum of a sample equals the lookup in its direction and in registers") {
  const Envmap map = uplifted(rotated(make_envmap(uneven_image(), 1, false)));
  const Spectrum<Wide> lambda(430, 510, 590, 670);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const auto one = [i](int lane) { return random4<Scalar>(8, i, static_cast<std::uint32_t>(lane), 0); };
    const WideFloat u = wide_floats([&](int lane) { return one(lane).x; });
    const WideFloat v = wide_floats([&](int lane) { return one(lane).y; });
    const auto wide = sample_envmap<Wide, kSpectral>(map.view(), u, v, lambda);
    const auto looked_up = lookup_envmap<Wide, kSpectral>(map.view(), wide.direction, lambda);
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto s = sample_envmap<Scalar, kSpectral>(map.view(), one(lane).x, one(lane).y, kSomeWavelengths);
      const auto plain = sample_envmap<Scalar>(map.view(), one(lane).x, one(lane).y);
      CHECK(s.direction.x == plain.direction.x);
      CHECK(difference(s.pdf_solid_angle, plain.pdf_solid_angle) < 1e-5);
      CHECK(difference(wide.radiance.c0[lane], s.radiance.c0) < 1e-4);
      CHECK(difference(wide.radiance.c3[lane], s.radiance.c3) < 1e-4);
      CHECK(difference(wide.pdf_solid_angle[lane], s.pdf_solid_angle) < 1e-4);
      const auto value = lookup_envmap<Scalar, kSpectral>(map.view(), s.direction, kSomeWavelengths);
      CHECK(difference(value.radiance.c1, s.radiance.c1) < 2e-3);
      CHECK(difference(looked_up.radiance.c2[lane], s.radiance.c2) < 2e-3);
    }
  }
}

TEST_CASE("environment map: only spectral mode stores spectra and includes them in its memory") {
  const TemporaryFolder folder;
  write_hdr(folder / "plain.hdr", 2, 2, {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3});
  Description d = empty_scene(4, 4);
  d.lights.push_back({EnvmapDescription{folder / "plain.hdr", 1, {}, false}, {}});
  CHECK(compile_scene(d)->view().lights.envmap.spectra == nullptr);
  CHECK(compile_scene(d, {false, kSpectral})->view().lights.envmap.spectra != nullptr);
  Envmap map = make_envmap(uneven_image(), 1, false);
  const std::size_t before = map.bytes();
  uplift_nodes(map);
  CHECK(map.bytes() - before == 11 * 7 * 16);
}

TEST_CASE("environment map: sampling is monotonic and preserves stratification") {
  const Envmap map = make_envmap(uneven_image(), 1, false);
  float before = -1;
  for (int i = 0; i < 4096; ++i) {
    const float v = static_cast<float>(i) / 4096;
    const auto s = sample_envmap<Scalar>(map.view(), 0.3f, v);
    const float polar = std::acos(std::clamp(s.direction.y, -1.0f, 1.0f));
    CHECK(polar >= before - 1e-3f);
    before = polar;
  }
}

TEST_CASE("environment map: the mean is the average over all directions") {
  const Envmap map = make_envmap(uneven_image(), 3, false);
  double sum = 0;
  constexpr std::uint32_t kSide = 600;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const std::uint32_t column = i % kSide, row = i / kSide;
    const Vec3f w =
        square_to_sphere<Scalar>((static_cast<float>(column) + 0.5f) / kSide, (static_cast<float>(row) + 0.5f) / kSide);
    sum += lookup_envmap<Scalar>(map.view(), w).radiance.c1;
  }
  CHECK(sum / (kSide * kSide) == near(map.mean.y, 2e-3));
}

TEST_CASE("environment map: image files are checked and invalid ones are reported") {
  const TemporaryFolder folder;
  const auto scene_with = [&](const char* name) {
    Description d = empty_scene(4, 4);
    d.lights.push_back({EnvmapDescription{folder / name, 1, {}, false}, {"scene.xml", 5}});
    return d;
  };
  write_hdr(folder / "plain.hdr", 2, 2, {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3});
  write_pnm(folder / "grey.pgm", 2, 1, 1, 255, {255, 188});
  write_hdr(folder / "black.hdr", 2, 2, std::vector<int>(12, 0));
  write_bytes(folder / "broken.exr", "v/1");
  Image bad(2, 2, {"R", "G", "B"});
  bad.data = {1, 1, 1, NAN, 1, 1, -5, 1, 1, 1, INFINITY, 1};
  write_exr(folder / "bad.exr", bad, {});

  const auto plain = compile_scene(scene_with("plain.hdr"));
  CHECK(plain->view().lights.environment == 0);
  CHECK(plain->warnings().empty());
  CHECK(lookup_envmap<Scalar>(plain->view().lights.envmap, {0, 0, 1}).radiance.c2 == near(3));
  const auto gray = compile_scene(scene_with("grey.pgm"));
  CHECK(lookup_envmap<Scalar>(gray->view().lights.envmap, direction_of(0.25, 0.3)).radiance.c0 == near(1));
  const auto darker = lookup_envmap<Scalar>(gray->view().lights.envmap, direction_of(0.75, 0.3)).radiance;
  CHECK(darker.c2 == near(0.5029, 1e-3));
  Description linear = scene_with("grey.pgm");
  std::get<EnvmapDescription>(linear.lights.at(0).model).raw = true;
  CHECK(lookup_envmap<Scalar>(compile_scene(linear)->view().lights.envmap, direction_of(0.75, 0.3)).radiance.c2 ==
        near(linear_to_srgb(0.5029f), 1e-3));
  const auto black = compile_scene(scene_with("black.hdr"));
  CHECK(black->view().lights.environment == kNone);
  CHECK(black->view().lights.count == 0);
  CHECK(black->warnings().size() == 1);
  const auto repaired = compile_scene(scene_with("bad.exr"));
  REQUIRE(repaired->warnings().size() == 1);
  CHECK(repaired->warnings()[0].find("3 values that are negative or not finite: 2 count as 0, 1 infinite as 65504") !=
        std::string::npos);
  EnvmapImage values = read_envmap_image(folder / "bad.exr");
  const UnusableValues counts = replace_unusable(values);
  CHECK(counts.infinite == 1);
  CHECK(counts.dark == 2);
  CHECK(values.rgb == std::vector<float>{1, 1, 1, 0, 1, 1, 0, 1, 1, 1, 65504, 1});
  for (std::uint32_t i = 0; i < 500; ++i) {
    const auto u = random4<Scalar>(6, i, 0, 0);
    const auto s = sample_envmap<Scalar>(repaired->view().lights.envmap, u.x, u.y);
    CHECK((is_finite(s.pdf_solid_angle) && is_finite(s.direction) && s.radiance.c0 >= 0 && s.radiance.c1 <= 65536 &&
           s.radiance.c2 <= 1.001f));
  }
  CHECK_THROWS_AS(compile_scene(scene_with("broken.exr")), SceneError);
  CHECK_THROWS_AS(compile_scene(scene_with("missing.exr")), SceneError);

  Description two = scene_with("plain.hdr");
  add_constant_light(two, 1);
  CHECK_THROWS_AS(compile_scene(two), SceneError);
  Description stretched = scene_with("plain.hdr");
  std::get<EnvmapDescription>(stretched.lights[0].model).to_world = Transform::scale({1, 2, 1});
  CHECK_THROWS_AS(compile_scene(stretched), SceneError);
}

TEST_CASE("environment map: sampling a small sun has 1/1000 of the variance of uniform sampling") {
  const auto image = envmap_image(128, 64, [](std::uint32_t x, std::uint32_t y) {
    return x == 40 && y == 20 ? Vec3f{1e4f, 1e4f, 1e4f} : Vec3f{1, 1, 1};
  });
  const Envmap map = make_envmap(image, 1, false);
  MeanVariance sampled, uniform;
  for (std::uint32_t i = 0; i < 100000; ++i) {
    const auto u = random4<Scalar>(7, i, 0, 0);
    const auto s = sample_envmap<Scalar>(map.view(), u.x, u.y);
    sampled.add(s.pdf_solid_angle > 0 ? s.radiance.c1 * std::max(s.direction.y, 0.0f) / s.pdf_solid_angle : 0);
    const Vec3f w = square_to_sphere<Scalar>(u.z, u.w);
    uniform.add(lookup_envmap<Scalar>(map.view(), w).radiance.c1 * std::max(w.y, 0.0f) * 4 * kPiD);
  }
  const double error = std::sqrt((sampled.variance() + uniform.variance()) / 100000);
  CHECK(std::fabs(sampled.mean() - uniform.mean()) < 4.5 * error);
  CHECK(uniform.variance() > 1000 * sampled.variance());
}

}  // namespace sheaf::test_envmap

// Renders with environment maps: all strategies agree in both color modes, with and without MIS compensation.
#include "core/math/frame.h"
#include "core/sampling/warp.h"
#include "kernels/lights/envmap.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/envmap_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/spectral_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace sheaf::test_envmap_light {

using test::envmap_image;
using test::uneven_image;
using test::write_map;

namespace {

constexpr double kPiD = std::numbers::pi;

/// Irradiance of a floor with normal `n` under a map, by a regular grid of directions over the hemisphere.
double irradiance(const EnvmapView& map, Vec3f n) {
  const auto frame = Frame<Scalar>::from_normal(n);
  double sum = 0;
  constexpr std::uint32_t kSide = 1500;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const std::uint32_t column = i % kSide, row = i / kSide;
    const Vec3f w = square_to_cosine_hemisphere<Scalar>((static_cast<float>(column) + 0.5f) / kSide,
                                                        (static_cast<float>(row) + 0.5f) / kSide);
    sum += lookup_envmap<Scalar>(map, frame.to_world(w)).radiance.c1;
  }
  return kPiD * sum / (double(kSide) * kSide);
}

}  // namespace

TEST_CASE("environment map: the bits do not depend on which paths share registers for light sampling") {
  const TemporaryFolder folder;
  write_map(folder / "map.exr", uneven_image());
  Description d = empty_scene(40, 30);
  d.sampler.sample_count = 4;
  look_at(d, {0, 1, 4}, {0, 0, 0}, {0, 1, 0}, 45);
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}), add_diffuse(d, 0.7f));
  add_sphere(d, {0.3f, 0.6f, 0}, 0.6f, add_diffuse(d, 0.4f));
  d.lights.push_back({EnvmapDescription{folder / "map.exr", 1, Transform(), true}, {}});
  for (const int candidates : {1, 3}) {
    d.integrator.candidates = candidates;
    const auto scene = compile_scene(d);
    RenderOptions options;
    options.threads = 1;
    options.wave_size = 1;
    const Image expected = render(*scene, options).film.to_image();
    REQUIRE(expected.at(20, 25, 1) > 0.0f);
    for (const int wave_size : {17, 64, 256, 1024}) {
      CAPTURE(candidates);
      CAPTURE(wave_size);
      options.threads = wave_size == 64 ? 2 : 1;
      options.wave_size = wave_size;
      CHECK(render(*scene, options).film.to_image().data == expected.data);
    }
  }
}

TEST_CASE("environment map: all strategies agree on a diffuse floor" * doctest::test_suite("slow")) {
  const TemporaryFolder folder;
  write_map(folder / "map.exr", uneven_image());
  for (const bool compensated : {false, true}) {
    Description d = empty_scene(32, 32);
    d.sampler.sample_count = 256;
    d.integrator.max_depth = 2;
    look_at(d, {1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 0.01f);
    add_rectangle(d, Transform::rotate({1, 0.3f, 0}, -60), add_diffuse(d, 0.5f));
    const Transform rotation = Transform::rotate({1, 2, 3}, 70);
    d.lights.push_back({EnvmapDescription{folder / "map.exr", 1, rotation, compensated}, {}});
    const Vec3f normal = Transform::rotate({1, 0.3f, 0}, -60).vector({0, 0, 1});
    const double expected = 0.5 / kPiD * irradiance(compile_scene(d)->view().lights.envmap, normal);
    for (const LightStrategy strategy : {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly}) {
      d.integrator.strategy = strategy;
      const Image out = render(*compile_scene(d), {}).film.to_image();
      MeanVariance statistics;
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) statistics.add(out.at(x, y, 1));
      CAPTURE(compensated);
      CAPTURE(static_cast<int>(strategy));
      CAPTURE(statistics.mean());
      CAPTURE(expected);
      constexpr double kGridError = 3e-4;
      const double off = std::fabs(statistics.mean() - expected);
      CHECK(off < kGridError * expected + 4.5 * std::sqrt(statistics.variance() / 1024));
      CHECK(std::sqrt(statistics.variance() / 1024) < 0.01 * expected);
    }
  }
}

namespace {

/// Means of R, G and B over images with seeds 1 to 24, with their variance.
std::array<MeanVariance, 3> means_of_seeds(const Scene& scene) {
  std::array<MeanVariance, 3> means;
  for (std::uint32_t seed = 1; seed <= 24; ++seed) {
    RenderOptions options;
    options.seed = seed;
    const Image out = render(scene, options).film.to_image();
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (int i = 0; i < 64; ++i) sum += static_cast<double>(out.at(i % 8, i / 8, c));
      means[static_cast<std::size_t>(c)].add(sum / 64);
    }
  }
  return means;
}

/// Means of a diffuse floor under a map.
std::array<MeanVariance, 3> floor_means(const std::filesystem::path& map, ColorMode color, LightStrategy strategy) {
  Description d = empty_scene(8, 8);
  d.sampler.sample_count = 512;
  d.integrator.max_depth = 2;
  d.integrator.strategy = strategy;
  look_at(d, {1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 0.01f);
  add_rectangle(d, Transform::rotate({1, 0.3f, 0}, -60), add_diffuse(d, 0.5f));
  d.lights.push_back({EnvmapDescription{map, 1, Transform::rotate({1, 2, 3}, 70), false}, {}});
  return means_of_seeds(*compile_scene(d, {false, color}));
}

/// Student's t-test of two means of 24 values each. `systematic` is the relative difference that is allowed in
/// addition.
void check_agree(const std::array<MeanVariance, 3>& a, const std::array<MeanVariance, 3>& b, double systematic) {
  for (std::size_t c = 0; c < 3; ++c) {
    const double error = std::sqrt((a[c].variance() + b[c].variance()) / 24);
    const double off = std::fabs(a[c].mean() - b[c].mean()) - systematic * b[c].mean();
    CAPTURE(c);
    CAPTURE(a[c].mean());
    CAPTURE(b[c].mean());
    CHECK(student_t_p_value(std::max(off, 0.0) / error, 23) > significance_of_each(9));
    CHECK(error < 0.005 * b[c].mean());
  }
}

}  // namespace

TEST_CASE("environment map: spectral mode shows a smooth map as RGB mode does" * doctest::test_suite("slow")) {
  const TemporaryFolder folder;
  write_map(folder / "smooth.exr", envmap_image(64, 32, [](std::uint32_t x, std::uint32_t y) {
              const float rotation = std::sin(kPi * static_cast<float>(x) / 32),
                          polar = std::cos(kPi * static_cast<float>(y) / 31);
              return Vec3f{1 + 0.6f * rotation, 0.9f + 0.4f * polar, 1.2f - 0.5f * rotation * polar};
            }));
  // Errors of the upsampling table and of the two ways of interpolation.
  constexpr double kSystematic = 0.004;
  check_agree(floor_means(folder / "smooth.exr", ColorMode::kSpectral, LightStrategy::kMis),
              floor_means(folder / "smooth.exr", ColorMode::kRgb, LightStrategy::kMis), kSystematic);
}

TEST_CASE("environment map: all strategies agree in spectral mode" * doctest::test_suite("slow")) {
  const TemporaryFolder folder;
  write_map(folder / "uneven.exr", uneven_image());
  const auto found = floor_means(folder / "uneven.exr", ColorMode::kSpectral, LightStrategy::kLightOnly);
  check_agree(floor_means(folder / "uneven.exr", ColorMode::kSpectral, LightStrategy::kBsdfOnly), found, 0);
  check_agree(floor_means(folder / "uneven.exr", ColorMode::kSpectral, LightStrategy::kMis), found, 0);
}

namespace {

/// A glossy sphere in a box of fog over a diffuse floor, under a map.
Description foggy_scene(const std::filesystem::path& map, bool compensated) {
  Description d = empty_scene(8, 8);
  d.sampler.sample_count = 128;
  look_at(d, {1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 40);
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({2, 2, 2}), add_diffuse(d, 0.5f));
  ConductorDescription metal;
  metal.roughness = RoughnessDescription{};
  add_sphere(d, {0, 0.5f, 0}, 0.5f, add_material(d, metal));
  fill(d, add_sphere(d, {0, 0.5f, 0}, 1.4f, MaterialId{0}), add_medium(d, fog(0.5f, 0.8f)));
  d.lights.push_back({EnvmapDescription{map, 1, Transform::rotate({1, 2, 3}, 70), compensated}, {}});
  return d;
}

}  // namespace

TEST_CASE("environment map: MIS compensation is unbiased on surfaces and in fog") {
  const TemporaryFolder folder;
  write_map(folder / "uneven.exr", uneven_image());
  const auto plain = compile_scene(foggy_scene(folder / "uneven.exr", false));
  const auto compensated = compile_scene(foggy_scene(folder / "uneven.exr", true));
  const auto expected = means_of_seeds(*plain), found = means_of_seeds(*compensated);
  for (std::size_t c = 0; c < 3; ++c) {
    const double error = std::sqrt((expected[c].variance() + found[c].variance()) / 24);
    const double off = std::fabs(expected[c].mean() - found[c].mean());
    CHECK(student_t_p_value(off / error, 23) > significance_of_each(3));
    CHECK(error < 0.005 * expected[c].mean());
  }
}

TEST_CASE("environment map: MIS compensation is used only where BSDF sampling covers dark texels") {
  const TemporaryFolder folder;
  write_map(folder / "uneven.exr", uneven_image());
  const auto is_compensated = [&](auto&& change) {
    Description d = foggy_scene(folder / "uneven.exr", true);
    change(d.integrator);
    return compile_scene(d)->view().lights.envmap.offset > 0;
  };
  CHECK(is_compensated([](IntegratorSettings&) {}));
  CHECK(!is_compensated([](IntegratorSettings& i) { i.strategy = LightStrategy::kLightOnly; }));
  CHECK(!is_compensated([](IntegratorSettings& i) { i.kind = IntegratorKind::kLightTracer; }));
  CHECK(!is_compensated([](IntegratorSettings& i) { i.kind = IntegratorKind::kPhotonMapper; }));
  CHECK(!is_compensated([](IntegratorSettings& i) { i.ends_at_diffuse = true; }));
}

}  // namespace sheaf::test_envmap_light

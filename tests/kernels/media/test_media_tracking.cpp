// Tracking of the medium that a ray is in: boundaries, nested and adjacent media, media in glass, and cameras inside of
// media.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_media_tracking {

namespace {

const double kLevel = significance_of_each(200);

Description small_scene() {
  Description d = empty_scene(16, 16);
  d.sampler.sample_count = 64;
  d.integrator.max_depth = 1;
  return d;
}

/// Tests the mean of the red channel.
void check_mean(const Description& d, double expected) {
  const Image image = render(*compile_scene(d), {}).film.to_image();
  MeanVariance m;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) m.add(image.at(x, y, 0));
  const double distance = m.mean() - expected, allowed = 3e-5 * std::fabs(expected);
  INFO("mean " << m.mean() << ", expected " << expected);
  CHECK(m.p_value(std::fabs(distance) <= allowed ? m.mean() : expected + std::copysign(allowed, distance)) >= kLevel);
}

/// A camera at `x` that looks along +x at a wall of radiance 1 at x = 10.
Description view_from(float x) {
  Description d = small_scene();
  look_at(d, {x, 0, 0}, {x + 1, 0, 0}, {0, 1, 0}, 0.01f);
  add_area_light_rectangle(
      d, Transform::translate({10, 0, 0}) * Transform::rotate({0, 1, 0}, -90) * Transform::scale({4, 4, 1}), 1);
  return d;
}

MediumId absorbing(Description& d, float sigma) { return add_medium(d, fog(sigma, 0)); }

ShapeDescription& cube(Description& d, float from, float to) {
  return add_shape(d, CubeShape{},
                   Transform::translate({0.5f * (from + to), 0, 0}) * Transform::scale({0.5f * (to - from), 1, 1}));
}

}  // namespace

TEST_CASE("media tracking: nested media are found with and without a named exterior") {
  for (const bool named : {true, false})
    for (const float from : {-3.0f, -1.5f, 0.0f}) {
      CAPTURE(named);
      CAPTURE(from);
      Description d = view_from(from);
      const MediumId outer = absorbing(d, 0.3f), inner = absorbing(d, 0.9f);
      fill(d, add_sphere(d, {0, 0, 0}, 2), outer);
      ShapeDescription& ball = fill(d, add_sphere(d, {0, 0, 0}, 1), inner);
      if (named) ball.exterior = outer;
      ball.exterior_is_surrounding = !named;
      const double before = from == -3 ? 2 * (0.3 + 0.9) : from == -1.5f ? 0.3 * 1.5 + 0.9 * 2 : 0.3 + 0.9;
      check_mean(d, std::exp(-before));
    }
}

TEST_CASE("media tracking: the innermost medium around the camera counts") {
  Description d = view_from(0);
  const MediumId a = absorbing(d, 0.1f), b = absorbing(d, 0.5f), c = absorbing(d, 2);
  for (const auto& [radius, medium] : {std::pair{3.0f, a}, std::pair{2.0f, b}, std::pair{1.0f, c}})
    fill(d, add_sphere(d, {0, 0, 0}, radius), medium).exterior_is_surrounding = true;
  check_mean(d, std::exp(-0.1 - 0.5 - 2));
}

TEST_CASE("media tracking: a global medium with objects of other media is tracked") {
  Description d = view_from(0);
  const MediumId haze = absorbing(d, 0.05f), dense = absorbing(d, 1);
  d.camera.medium = haze;
  fill(d, cube(d, 2, 3), dense).exterior_is_surrounding = true;
  check_mean(d, std::exp(-0.05 * 9 - 1));
}

TEST_CASE("media tracking: adjacent media are tracked") {
  Description d = view_from(0);
  const MediumId a = absorbing(d, 0.3f), b = absorbing(d, 0.6f);
  fill(d, cube(d, 2, 3), a);
  fill(d, cube(d, 3.001f, 5.001f), b);
  check_mean(d, std::exp(-0.3 - 1.2));
}

TEST_CASE("media tracking: an opaque object inside a medium ends the free flight") {
  Description d = view_from(0);
  fill(d, cube(d, 2, 8), absorbing(d, 0.2f));
  add_area_light_rectangle(d, Transform::translate({5, 0, 0}) * Transform::rotate({0, 1, 0}, -90), 7);
  check_mean(d, 7 * std::exp(-0.6));
}

TEST_CASE("media tracking: glass filled with a medium and glass inside a medium are tracked") {
  Description d = view_from(0);
  d.integrator.max_depth = 200;
  d.integrator.rr_depth = 1000;
  const double sigma = 0.4, eta = 1.5, r = (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)), t = std::exp(-sigma);
  // The wall is behind the slab. Transmittance of the slab with all inter-reflections:
  const double pane = (1 - r) * (1 - r) * t / (1 - r * r * t * t);
  ShapeDescription& glass = cube(d, 4, 5);
  glass.material = add_glass(d, static_cast<float>(eta));
  glass.interior = absorbing(d, static_cast<float>(sigma));
  check_mean(d, pane);
  // With haze from the camera to the wall there is an additional absorption.
  const MediumId haze = absorbing(d, 0.1f);
  d.camera.medium = haze;
  d.shapes.back().exterior = haze;
  check_mean(d, pane * std::exp(-0.9));
}

TEST_CASE("media tracking: shadow rays pass masks by their opacity and cross the media behind") {
  Description d = small_scene();
  d.integrator.max_depth = 2;
  look_at(d, {3, 0, 0.5f}, {0, 0, 0}, {0, 0, 1}, 0.01f);
  add_rectangle(d, Transform::scale({9, 9, 1}), add_diffuse(d, 0.5f));
  add_point_light(d, {0, 0, 4}, 16);
  const MaterialId black = add_diffuse(d, 0);
  const MaterialId veil = add_material(d, MaskDescription{0.3f, black});
  add_rectangle(d, Transform::translate({0, 0, 3}), veil);
  const MediumId smoke = absorbing(d, 0.5f);
  fill(d, add_sphere(d, {0, 0, 1.5f}, 1), smoke);
  const double open = 0.5 / 3.14159265358979 * 16 / 16;
  check_mean(d, open * 0.7 * std::exp(-1.0));
  // The same with a light that both BSDF sampling and light sampling find.
  d.lights.clear();
  add_area_light_sphere(d, {0, 0, 5}, 0.5f, 16);
  d.sampler.sample_count = 1024;
  const auto render_mean = [](const Description& scene) {
    const Image image = render(*compile_scene(scene), {}).film.to_image();
    MeanVariance m;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) m.add(image.at(x, y, 0));
    return m;
  };
  const MeanVariance both = render_mean(d);
  for (const LightStrategy strategy : {LightStrategy::kBsdfOnly, LightStrategy::kLightOnly}) {
    d.integrator.strategy = strategy;
    const MeanVariance alone = render_mean(d);
    INFO("means " << both.mean() << " and " << alone.mean());
    CHECK(student_t_p_value((both.mean() - alone.mean()) / std::sqrt((both.variance() + alone.variance()) / 256),
                            510) >= kLevel);
  }
}

TEST_CASE("media tracking: rays whose steps vanish in rounding are terminated") {
  const TemporaryFolder folder;
  Description d = empty_scene(1, 1);
  d.sampler.sample_count = 1;
  d.integrator.max_depth = 2;
  MediumDescription smoke = fog(1, 0.5f);
  // The medium is empty beyond x = 0.75, but the majorant covers the whole: it bounds only one of the two factors per
  // cell.
  const Transform to_world = Transform::translate({-0.9f, -0.5f, -0.5f});
  std::get<ExtinctionAlbedoDescription>(smoke.coefficients).sigma_t =
      vol(write_vol(folder / "a.vol", 2, 1, [](Vec3f p, int) { return p.x < 0.5f ? 1.0f : 0.0f; }), to_world);
  smoke.density = vol(write_vol(folder / "b.vol", 2, 1, [](Vec3f, int) { return 1e30f; }), to_world);
  fill(d, add_sphere(d, {0, 0, 0}, 2), add_medium(d, smoke));
  const auto rendered = [&] {
    RenderResult result = render(*compile_scene(d), {});
    CHECK(result.report.stats.collisions.abandoned == 1);
    CHECK(result.report.stats.dropped.samples + result.report.stats.dropped.rays == 0);
    REQUIRE(result.warnings.size() == 1);
    CHECK(result.warnings[0].find("rays were abandoned in a medium") != std::string::npos);
    return result.film.to_image().at(0, 0, 0);
  };
  // Light along camera rays.
  look_at(d, {0, 0, -5}, {0, 0, 0}, {0, 1, 0}, 0.01f);
  add_area_light_rectangle(d, Transform::translate({0, 0, 5}) * Transform::rotate({0, 1, 0}, 180), 1);
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  CHECK(rendered() == 0.0f);
  // Light along shadow rays to a floor.
  d.integrator.strategy = LightStrategy::kMis;
  d.shapes.pop_back();
  add_rectangle(d, Transform::translate({0, 0, 5}) * Transform::rotate({0, 1, 0}, 180), add_diffuse(d, 0.5f));
  add_point_light(d, {0, 0, -5}, 1);
  look_at(d, {0, 3, 4}, {0, 0, 5}, {0, 1, 0}, 0.01f);
  CHECK(rendered() == 0.0f);
}

TEST_CASE("media tracking: coefficients beyond the float range are errors with file and line") {
  const TemporaryFolder folder;
  const GridVolumeDescription large = vol(write_vol(folder / "large.vol", 2, 1, [](Vec3f, int) { return 3e38f; })),
                              one = vol(write_vol(folder / "one.vol", 2, 1, [](Vec3f, int) { return 1.0f; })),
                              color = vol(write_vol(folder / "color.vol", 2, 3,
                                                    [](Vec3f, int c) { return c == 1 ? 2e38f : 1.0f; }));
  const SpectrumDescription huge = SpectrumDescription::constant(3e38f), unit = SpectrumDescription::constant(1);
  const auto error_of = [](const std::function<void(MediumDescription&)>& change, ColorMode mode) -> std::string {
    MediumDescription m = fog(1, 0.5f);
    m.where = {"a.xml", 9};
    change(m);
    Description d = empty_scene(1, 1);
    fill(d, add_sphere(d, {0, 0, 0}, 1), add_medium(d, m));
    try {
      compile_scene(d, {false, mode});
    } catch (const SceneError& error) { return error.what(); }
    return {};
  };
  using Pair = ExtinctionAlbedoDescription;
  using Coefficients = AbsorptionScatteringDescription;
  const std::function<void(MediumDescription&)> too_dense[] = {
      [&](auto& m) {
        m.scale = 3, m.coefficients = Pair{huge, unit};
      },
      [&](auto& m) {
        m.scale = 3, m.coefficients = Pair{large, unit};
      },
      [&](auto& m) { m.scale = 3, m.density = large; },
      [&](auto& m) {
        m.density = large, m.coefficients = Pair{large, unit};
      },
      [&](auto& m) {
        m.density = large, m.coefficients = Coefficients{unit, unit};
      },
      [&](auto& m) {
        m.coefficients = Coefficients{huge, huge};
      },
      [&](auto& m) {
        m.scale = 3, m.coefficients = Coefficients{unit, huge};
      },
      [&](auto& m) {
        m.scale = 2, m.coefficients = Pair{color, unit};
      }};
  const std::function<void(MediumDescription&)> too_bright[] = {
      [&](auto& m) { m.emission = huge, m.emission_scale = 3; },
      [&](auto& m) { m.emission = large, m.emission_scale = 3; },
      [&](auto& m) { m.temperature = large, m.temperature_scale = 3; }};
  for (const ColorMode mode : {ColorMode::kRgb, ColorMode::kSpectral}) {
    for (const auto& change : too_dense) CHECK(error_of(change, mode).starts_with("a.xml:9: the medium's extinction "));
    for (const auto& change : too_bright)
      CHECK(error_of(change, mode).starts_with("a.xml:9: the medium's emission exceeds 32-bit floats"));
    CHECK(error_of([&](auto& m) { m.scale = 1e30f, m.density = one; }, mode).empty());
    CHECK(error_of([&](auto& m) { m.scale = 0, m.density = large; }, mode).empty());
  }
}

}  // namespace sheaf::test_media_tracking

// Renders of media whose extinction depends on color, against closed forms.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace sheaf::test_media_lanes {

namespace {

/// All comparisons of this file together fail with probability kSignificance if every estimator is unbiased.
const double kLevel = significance_of_each(250);
constexpr MediumEstimator kUnbiased[] = {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio};
constexpr int kSize = 16;

Description small_scene(int samples) {
  Description d = empty_scene(kSize, kSize);
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  d.sampler.seed = 17;
  return d;
}

using Means = std::array<MeanVariance, 3>;

Means means_of(const Description& d) {
  const Image image = render(*compile_scene(d, {}), {}).film.to_image();
  Means means;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) means[static_cast<std::size_t>(c)].add(image.at(x, y, c));
  return means;
}

/// `rounding` is the relative error that no number of samples averages out.
void check_mean(const MeanVariance& found, double expected, double rounding = 2e-4) {
  const double distance = found.mean() - expected, allowed = rounding * std::fabs(expected);
  INFO("mean " << found.mean() << ", expected " << expected << ", standard error "
               << std::sqrt(found.variance() / (kSize * kSize)));
  CHECK(found.p_value(std::fabs(distance) <= allowed ? found.mean() : expected + std::copysign(allowed, distance)) >=
        kLevel);
}

/// A wall of radiance 2 behind `medium` in the cube [0, 1]^3, seen along x.
Description wall_behind(const MediumDescription& medium) {
  Description d = small_scene(128);
  look_at(d, {-5, 0.5f, 0.5f}, {0, 0.5f, 0.5f}, {0, 1, 0}, 0.01f);
  d.integrator.max_depth = 1;
  add_area_light_rectangle(d, Transform::translate({5, 0.5f, 0.5f}) * Transform::rotate({0, 1, 0}, -90), 2);
  add_shape(d, CubeShape{}, Transform::translate({0.5f, 0.5f, 0.5f}) * Transform::scale({0.5f, 0.5f, 0.5f}));
  fill(d, d.shapes.back(), add_medium(d, medium));
  return d;
}

/// A diffuse floor of albedo 0.5, lit by a point light along y through `medium` in the cube [0, 1]^3.
Description floor_below(const MediumDescription& medium) {
  Description d = small_scene(128);
  look_at(d, {3, -2.0f, 0.5f}, {0.5f, -3, 0.5f}, {0, 1, 0}, 0.01f);
  d.integrator.max_depth = 2;
  add_rectangle(
      d, Transform::translate({0.5f, -3, 0.5f}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({9, 9, 1}),
      add_diffuse(d, 0.5f));
  add_point_light(d, {0.5f, 3, 0.5f}, 36);
  add_shape(d, CubeShape{}, Transform::translate({0.5f, 0.5f, 0.5f}) * Transform::scale({0.5f, 0.5f, 0.5f}));
  fill(d, d.shapes.back(), add_medium(d, medium));
  return d;
}
const double kFloor = 0.5 / 3.14159265358979;

/// Irradiance over pi of a white environment of radiance 1 below an infinite slab of optical thickness `depth`: twice
/// the exponential integral E3.
double below_slab(double depth) {
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = (i + 0.5) / kSteps;
    sum += 2 * cosine * std::exp(-depth / cosine);
  }
  return sum / kSteps;
}

/// A diffuse floor of albedo 0.5 that sees a white environment through a slab of `medium`, y in [0, 1], 200 wide.
Description floor_below_slab(const MediumDescription& medium) {
  Description d = small_scene(128);
  look_at(d, {0.05f, -0.05f, 0}, {0, -0.1f, 0}, {0, 1, 0}, 0.01f);
  d.integrator.max_depth = 2;
  add_constant_light(d, 1);
  add_rectangle(
      d, Transform::translate({0, -0.1f, 0}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({300, 300, 1}),
      add_diffuse(d, 0.5f));
  add_shape(d, CubeShape{}, Transform::translate({0, 0.5f, 0}) * Transform::scale({100, 0.5f, 100}));
  fill(d, d.shapes.back(), add_medium(d, medium));
  return d;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("media: gray absorption with colored scattering is unbiased where minorants of the densest color are used") {
  const TemporaryFolder folder;
  // Minorants are used up to an optical thickness of 2.3. The last color exceeds it, whichever is the hero wavelength.
  const float scattering[] = {0.1f, 0.8f, 2.5f};
  const auto ones = vol(write_vol(folder / "ones.vol", 2, 1, [](Vec3f, int) { return 1.0f; }));
  const auto gray = vol(write_vol(folder / "grey.vol", 2, 1, [](Vec3f, int) { return 0.5f; }));
  const auto grays = vol(write_vol(folder / "greys.vol", 2, 3, [](Vec3f, int) { return 0.5f; }));
  const auto colors = vol(write_vol(folder / "colors.vol", 2, 3, [&](Vec3f, int c) { return scattering[c]; }));
  MediumDescription by_density, by_grids, by_colors;
  by_density.coefficients =
      AbsorptionScatteringDescription{SpectrumDescription::constant(0.5f), SpectrumDescription::rgb(0.1f, 0.8f, 2.5f)};
  by_density.density = ones;
  by_grids.coefficients = AbsorptionScatteringDescription{gray, colors};
  by_colors.coefficients = AbsorptionScatteringDescription{grays, colors};
  for (const MediumDescription& medium : {by_density, by_grids, by_colors})
    for (const MediumEstimator estimator : kUnbiased) {
      CAPTURE(medium.density.has_value());
      CAPTURE(static_cast<int>(estimator));
      Description through = wall_behind(medium), below = floor_below(medium);
      through.integrator.medium_estimator = below.integrator.medium_estimator = estimator;
      const Means seen = means_of(through), lit = means_of(below);
      for (std::size_t c = 0; c < 3; ++c) {
        CAPTURE(c);
        const double passed = std::exp(-0.5 - static_cast<double>(scattering[c]));
        check_mean(seen[c], 2 * passed);
        check_mean(lit[c], kFloor * passed, 5e-4);
      }
    }
}

TEST_CASE("media: the MIS weights through a colored medium add up by their pdfs") {
  const TemporaryFolder folder;
  const Transform slab = Transform::translate({-100, 0, -100}) * Transform::scale({200, 1, 200});
  const float extinction[] = {0.4f, 1.5f, 3};
  // The density rises from 0.25 to 0.75 across the slab, below its majorant, so that there are null collisions.
  const auto ramp = vol(write_vol(folder / "ramp.vol", 2, 1, [](Vec3f p, int) { return p.y; }), slab);
  const auto colors =
      vol(write_vol(folder / "colors.vol", 2, 3, [&](Vec3f p, int c) { return extinction[c] * p.y; }), slab);
  MediumDescription single = fog(1, 0.5f), grid = fog(1, 0.5f);
  std::get<ExtinctionAlbedoDescription>(single.coefficients).sigma_t = SpectrumDescription::rgb(0.4f, 1.5f, 3);
  single.density = ramp;
  std::get<ExtinctionAlbedoDescription>(grid.coefficients).sigma_t = colors;
  for (const MediumDescription& medium : {single, grid})
    for (const MediumEstimator estimator : kUnbiased)
      for (const LightStrategy strategy : {LightStrategy::kMis, LightStrategy::kBsdfOnly}) {
        CAPTURE(medium.density.has_value());
        CAPTURE(static_cast<int>(estimator));
        CAPTURE(static_cast<int>(strategy));
        Description d = floor_below_slab(medium);
        d.integrator.medium_estimator = estimator;
        d.integrator.strategy = strategy;
        const Means found = means_of(d);
        for (std::size_t c = 0; c < 3; ++c) {
          CAPTURE(c);
          check_mean(found[c], 0.5 * below_slab(0.5 * static_cast<double>(extinction[c])), 5e-4);
        }
      }
}

TEST_SUITE_END();

}  // namespace sheaf::test_media_lanes

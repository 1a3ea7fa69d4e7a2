// Light that fog scatters around lamps: the segment_lights stage and the lobes towards lights, against a quadrature and
// against estimators that use neither.
#include "scene/tables/medium_lookup.h"
#include "tests/support/instancing_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <cmath>

namespace sheaf::test_segment_lights {

namespace {

constexpr double kPiD = 3.14159265358979323846;

struct Lamp {
  Vec3f position;
  float intensity;
};
/// Beside the camera's ray, close to it, and behind its origin.
const std::vector<Lamp> kLamps{{{3, 0.4f, 0}, 2}, {{6, 0, -0.02f}, 0.1f}, {{-1, 1, 1}, 5}, {{5, -3, 2}, 9}};
constexpr float kGravity = 0.6f;
const std::array<double, 3> kScattering{0.05, 0.12, 0.3}, kAbsorption{0.02, 0.0, 0.05};
constexpr float kHalf = 10;  ///< half the side of the cube of fog

/// A cube of colored fog around the origin, from where the camera looks along the x axis.
Description in_fog(int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, {0, 0, 0}, {1, 0, 0});
  MediumDescription m;
  const auto rgb = [](const std::array<double, 3>& c) {
    return SpectrumDescription::rgb(static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]));
  };
  m.coefficients = AbsorptionScatteringDescription{rgb(kAbsorption), rgb(kScattering)};
  m.phase = add_phase(d, kGravity);
  const MediumId medium = add_medium(d, m);
  fill(d, add_shape(d, CubeShape{}, Transform::scale({kHalf, kHalf, kHalf})), medium);
  return d;
}

/// Replaces the fog by a gray medium whose density varies in all directions. Returns its grid file.
void vary_density(Description& d, const TemporaryFolder& folder) {
  const auto density = [](Vec3f p, int) { return 0.2f + 3 * p.x * p.y + (p.z < 0.4f ? 0.0f : 1.5f * p.z); };
  MediumDescription& m = d.media[0];
  m.coefficients = ExtinctionAlbedoDescription{
      vol(write_vol(folder / "density.vol", 8, 1, density),
          Transform::scale({2 * kHalf, 2 * kHalf, 2 * kHalf}) * Transform::translate({-0.5f, -0.5f, -0.5f})),
      SpectrumDescription::rgb(0.9f, 0.6f, 0.3f)};
  m.scale = 0.2f;
}

/// The mean over three channels of what a gray medium scatters once towards the camera from point lamps, over the
/// albedo.
double scattered_once_by_grid(const SceneView& scene) {
  constexpr int kSteps = 4000, kShadowSteps = 200;
  const MediumRow& medium = scene.media.rows[0];
  const MediumSpectra spectra = medium_spectra(scene, medium, {});
  const auto extinction = [&](Vec3f p) {
    return double{medium_coefficients(scene, medium, spectra, p, {}).sigma_t[0]};
  };
  const double g = double{kGravity}, step = double{kHalf} / kSteps;
  double sum = 0, thickness = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3f p{kHalf * (static_cast<float>(i) + 0.5f) / kSteps, 0, 0};
    const double sigma_t = extinction(p), to_middle = thickness + 0.5 * sigma_t * step;
    for (const Lamp& lamp : kLamps) {
      const Vec3f d = lamp.position - p;
      const double distance = double{length(d)};
      double shadow = 0;
      for (int k = 0; k < kShadowSteps; ++k)
        shadow += extinction(p + d * ((static_cast<float>(k) + 0.5f) / kShadowSteps)) * distance / kShadowSteps;
      const double cosine = double{d.x} / distance;
      const double phase = (1 - g * g) / (4 * kPiD * std::pow(1 + g * g - 2 * g * cosine, 1.5));
      sum += sigma_t * std::exp(-to_middle - shadow) * phase * double{lamp.intensity} / (distance * distance) * step;
    }
    thickness += sigma_t * step;
  }
  return sum;
}

/// Radiance that the fog scatters once towards the camera from point lamps.
double scattered_once(std::size_t channel) {
  constexpr int kSteps = 400000;
  const double sigma_s = kScattering[channel], sigma_t = sigma_s + kAbsorption[channel], g = double{kGravity};
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = double{kHalf} * (i + 0.5) / kSteps;
    for (const Lamp& lamp : kLamps) {
      const double x = double{lamp.position.x} - t, y = double{lamp.position.y}, z = double{lamp.position.z};
      const double squared = x * x + y * y + z * z, distance = std::sqrt(squared);
      // Light that goes on straight ahead towards the camera comes from a lamp with x > 0.
      const double cosine = x / distance;
      const double phase = (1 - g * g) / (4 * kPiD * std::pow(1 + g * g - 2 * g * cosine, 1.5));
      sum += std::exp(-sigma_t * (t + distance)) * phase * double{lamp.intensity} / squared;
    }
  }
  return sigma_s * sum * double{kHalf} / kSteps;
}

void check_quadrature(const Description& d, double level) {
  const PixelMeans found = pixel_means(d);
  for (std::size_t c = 0; c < 3; ++c) {
    CAPTURE(c);
    const double expected = scattered_once(c);
    check_mean(found[c], expected, level, 1e-4 * expected);
  }
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("segment lights: light scattered once equals the quadrature for every estimator and number of candidates") {
  const double level = significance_of_each(3 * 2 * 3);
  for (const MediumEstimator estimator : {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio})
    for (const int candidates : {1, 4}) {
      CAPTURE(static_cast<int>(estimator));
      CAPTURE(candidates);
      Description d = in_fog(32);
      for (const Lamp& lamp : kLamps) add_point_light(d, lamp.position, lamp.intensity);
      d.integrator.medium_estimator = estimator;
      d.integrator.candidates = candidates;
      d.integrator.max_depth = 2;
      check_quadrature(d, level);
    }
}

TEST_CASE("segment lights: light scattered once in a grid equals the quadrature for every estimator") {
  constexpr double kAlbedos[] = {0.9, 0.6, 0.3};
  const double level = significance_of_each(3 * 2 * 3);
  const TemporaryFolder folder;
  for (const MediumEstimator estimator : {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio})
    for (const int candidates : {1, 4}) {
      CAPTURE(static_cast<int>(estimator));
      CAPTURE(candidates);
      Description d = in_fog(64);
      vary_density(d, folder);
      for (const Lamp& lamp : kLamps) add_point_light(d, lamp.position, lamp.intensity);
      d.integrator.medium_estimator = estimator;
      d.integrator.candidates = candidates;
      d.integrator.max_depth = 2;
      const auto scene = compile_scene(d);
      REQUIRE(scene->view().media.connects_segments);
      const double expected = scattered_once_by_grid(scene->view());
      const PixelMeans found = pixel_means(d);
      for (std::size_t c = 0; c < 3; ++c) {
        CAPTURE(c);
        check_mean(found[c], kAlbedos[c] * expected, level, 1e-3 * kAlbedos[c] * expected);
      }
    }
}

TEST_CASE("segment lights: all strategies agree on spheres in a grid, in both color modes") {
  const double level = significance_of_each(2 * 3 * 3);
  const TemporaryFolder folder;
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    Description d = in_fog(96);
    vary_density(d, folder);
    add_area_light_sphere(d, {3, 0.9f, 0}, 0.5f, 4);
    add_area_light_sphere(d, {6, -2, 1}, 0.8f, 3);
    d.integrator.max_depth = 4;
    check_strategies_agree(d, level, color);
  }
}

TEST_CASE("segment lights: beams, moving lights and instanced fog have the same means as without") {
  const double level = significance_of_each(3 * 3);
  // Ray marching connects no segments, and treats homogeneous media alike otherwise.
  const auto check = [&](const char* name, Description d) {
    CAPTURE(name);
    d.integrator.max_depth = 3;
    REQUIRE(compile_scene(d)->view().media.connects_segments);
    PixelMeans means[2];
    for (const bool marches : {false, true}) {
      if (marches) d.integrator.medium_estimator = MediumEstimator::kMarching;
      d.sampler.seed += 1;
      means[marches] = pixel_means(d);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      CAPTURE(c);
      check_same_mean(means[0][c], means[1][c], level);
    }
  };
  SUBCASE("beams") {
    Description d = in_fog(128);
    const auto add_spot = [&](Vec3f from, Vec3f at, float cutoff_angle) {
      SpotLightDescription spot;
      spot.to_world = Transform::look_at(from, at, {0, 0.1f, 1});
      spot.cutoff_angle = cutoff_angle, spot.beam_width = 0.8f * cutoff_angle;
      spot.intensity = SpectrumDescription::constant(9);
      d.lights.push_back({spot, {}});
    };
    add_spot({3, 2, 1}, {3.5f, 0, 0}, 12);      // across the ray
    add_spot({1, 0.5f, 0}, {9, -0.5f, 0}, 30);  // along the ray
    add_spot({8, 0.3f, 0.2f}, {0, 0, 0}, 25);   // towards the camera
    add_spot({4, 3, 0}, {4, 9, 0}, 40);         // away from the ray
    check("beams", d);
  }
  SUBCASE("a moving light") {
    Description d = in_fog(128);
    move(d, add_area_light_sphere(d, {3, 0.9f, 0}, 0.5f, 4),
         {{0, Transform()}, {1, Transform::translate({2, -2, 0.5f})}});
    expose(d, 0, 1);
    check("a moving light", d);
  }
  SUBCASE("fog in an instance") {
    Description d = in_fog(128);
    std::vector<ShapeDescription> shapes{d.shapes.back()};
    d.shapes.pop_back();
    add_instance(d, add_group(d, shapes), Transform::translate({2, 0, 0}));
    look_at_point(d, {-20, 0, 0}, {1, 0, 0});
    for (const Lamp& lamp : kLamps) add_point_light(d, lamp.position, lamp.intensity);
    check("fog in an instance", d);
  }
}

TEST_CASE("segment lights: their noise in thin fog is far below that of sampling distances") {
  // Ray marching connects no segments.
  const auto variance = [](MediumEstimator estimator) {
    Description d = in_fog(16);
    for (const Lamp& lamp : kLamps) add_point_light(d, lamp.position, lamp.intensity);
    d.integrator.medium_estimator = estimator;
    d.integrator.max_depth = 2;
    return pixel_means(d)[0].variance();
  };
  CHECK(variance(MediumEstimator::kNullMis) < 0.1 * variance(MediumEstimator::kMarching));
}

TEST_CASE("segment lights: the last rays of paths are not connected, whichever paths share a register") {
  Description d = in_fog(4);
  look_at(d, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 60);
  for (const Lamp& lamp : kLamps) add_point_light(d, lamp.position, lamp.intensity);
  d.integrator.max_depth = 2;
  const auto scene = compile_scene(d);
  const auto image = [&](int wave_size) {
    RenderOptions options;
    options.wave_size = wave_size;
    return render(*scene, options).film.to_image();
  };
  CHECK(image(64).data == image(1024).data);
}

TEST_CASE("segment lights: all strategies agree on spheres and rectangles in fog, in both color modes") {
  const double level = significance_of_each(2 * 3 * 3);
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    Description d = in_fog(color == ColorMode::kRgb ? 96 : 64);
    add_area_light_sphere(d, {3, 0.9f, 0}, 0.5f, 4);
    add_area_light_sphere(d, {6, -2, 1}, 0.8f, 3);
    add_area_light_rectangle(d, Transform::translate({4, 0, 2}) * Transform::rotate({1, 0, 0}, 180), 2);
    add_rectangle(d, Transform::translate({0, 0, -2}) * Transform::scale({8, 8, 1}), add_diffuse(d, 0.6f));
    d.integrator.max_depth = 5;
    check_strategies_agree(d, level, color);
  }
}

TEST_CASE("segment lights: paths and light tracing agree on lamps beside surfaces in fog") {
  const double level = significance_of_each(3);
  const auto scene = [](IntegratorKind kind) {
    Description d = in_fog(kind == IntegratorKind::kPath ? 64 : 256);
    // Light tracing needs an image of some size.
    look_at(d, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 40);
    add_point_light(d, {3, 0.6f, 0.3f}, 1);
    add_point_light(d, {5, -1, -0.5f}, 2);
    add_rectangle(d, Transform::translate({0, 0, -1}) * Transform::scale({8, 8, 1}),
                  add_two_sided(d, add_diffuse(d, 0.6f)));
    d.integrator.kind = kind;
    d.integrator.max_depth = 4;
    return pixel_means(d);
  };
  const PixelMeans path = scene(IntegratorKind::kPath), light = scene(IntegratorKind::kLightTracer);
  for (std::size_t c = 0; c < 3; ++c) {
    CAPTURE(c);
    // Pixels differ in radiance, alike in both.
    check_same_mean(path[c], light[c], level);
  }
}

}  // namespace sheaf::test_segment_lights

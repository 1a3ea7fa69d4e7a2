// Renders of media against closed forms and against each other.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/formats/nanovdb.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace sheaf::test_media_estimators {

namespace {

/// All comparisons of this file together fail with probability kSignificance if every estimator is unbiased.
const double kLevel = significance_of_each(2000);
constexpr MediumEstimator kUnbiased[] = {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio};

Description small_scene(int samples = 128) {
  Description d = empty_scene(32, 32);
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  d.sampler.seed = 11;
  return d;
}

void aim(Description& d, Vec3f from, Vec3f at) { look_at(d, from, at, {0, 1, 0}, 0.01f); }

struct Means {
  MeanVariance channel[3];
};

Means means_of(const Description& d, ColorMode color = ColorMode::kRgb) {
  CompileOptions options;
  options.color = color;
  const Image image = render(*compile_scene(d, options), {}).film.to_image();
  Means m;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) m.channel[c].add(image.at(x, y, c));
  return m;
}

/// `rounding` is the relative error of single precision, which no number of samples averages out.
void check_mean(const MeanVariance& statistics, double expected, double rounding = 2e-5) {
  const double distance = statistics.mean() - expected, allowed = rounding * std::fabs(expected);
  INFO("mean " << statistics.mean() << ", expected " << expected << ", standard error "
               << std::sqrt(statistics.variance() / 1024));
  const double nearest =
      std::fabs(distance) <= allowed ? statistics.mean() : expected + std::copysign(allowed, distance);
  CHECK(statistics.p_value(nearest) >= kLevel);
}

void check_gray(const Description& d, double expected) {
  const Means m = means_of(d);
  for (const MeanVariance& channel : m.channel) check_mean(channel, expected);
}

/// Tests that two renders have the same mean.
void check_equal(const MeanVariance& a, const MeanVariance& b) {
  const double error = std::sqrt((a.variance() + b.variance()) / 1024);
  INFO("means " << a.mean() << " and " << b.mean() << ", standard error " << error);
  if (error > 0) {
    CHECK(student_t_p_value((a.mean() - b.mean()) / error, 2046) >= kLevel);
  } else {
    CHECK(a.mean() == near(b.mean()));
  }
}

/// An emissive wall behind the cube [0, 1]^3, seen through it along x from far away.
Description wall_behind_cube() {
  Description d = small_scene();
  aim(d, {-5, 0.5f, 0.5f}, {0, 0.5f, 0.5f});
  d.integrator.max_depth = 1;
  add_area_light_rectangle(d, Transform::translate({3, 0.5f, 0.5f}) * Transform::rotate({0, 1, 0}, -90), 2);
  add_shape(d, CubeShape{}, Transform::translate({0.5f, 0.5f, 0.5f}) * Transform::scale({0.5f, 0.5f, 0.5f}));
  return d;
}

/// A diffuse floor, lit by a point light through the cube.
Description floor_below_cube() {
  Description d = small_scene();
  aim(d, {3, -2.0f, 0.5f}, {0.5f, -3, 0.5f});
  d.integrator.max_depth = 2;
  add_rectangle(
      d, Transform::translate({0.5f, -3, 0.5f}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({9, 9, 1}),
      add_diffuse(d, 0.5f));
  add_point_light(d, {0.5f, 3, 0.5f}, 36);
  add_shape(d, CubeShape{}, Transform::translate({0.5f, 0.5f, 0.5f}) * Transform::scale({0.5f, 0.5f, 0.5f}));
  return d;
}
const double kFloor = 0.5 / 3.14159265358979 * 36 / 36;

MediumDescription with_density(MediumDescription m, const GridVolumeDescription& grid) {
  m.density = grid;
  return m;
}

/// A NanoVDB grid of ones over a cube of side `side` around the origin.
GridVolumeDescription ones_in_nanovdb(const std::filesystem::path& file, float side) {
  constexpr int kBlocks = 2, kVoxels = 8 * kBlocks;
  VoxelBlocks blocks(1);
  const float one = 1;
  for (int i = 0; i < kBlocks * kBlocks * kBlocks; ++i)
    blocks.add_constant({i % kBlocks, i / kBlocks % kBlocks, i / kBlocks / kBlocks}, {&one, 1});
  const float voxel = side / (kVoxels - 1), corner = -0.5f * side;
  NanoVdbGrid grid;
  grid.name = "density";
  grid.voxels = &blocks;
  grid.index_to_world = Transform::translate({corner, corner, corner}) * Transform::scale({voxel, voxel, voxel});
  write_nanovdb(file, {&grid, 1});
  GridVolumeDescription description;
  description.file = file;
  description.format = GridVolumeDescription::Format::kSparse;
  return description;
}

/// The whole space, or a sphere of radius 1, filled with a medium in a white environment.
Description furnace(const MediumDescription& medium, float g) {
  Description d = small_scene(64);
  look_at(d, {0, 0, -3}, {0, 0, 0}, {0, 1, 0}, 20);
  d.integrator.rr_depth = 1000;
  add_constant_light(d, 1);
  MediumDescription m = medium;
  m.phase = add_phase(d, g);
  const MediumId id = add_medium(d, m);
  fill(d, add_sphere(d, {0, 0, 0}, 1), id);
  return d;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("media: paths and shadow rays match the transmittance of a homogeneous slab in each color") {
  for (const MediumEstimator estimator :
       {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio, MediumEstimator::kMarching})
    for (const float albedo : {0.0f, 0.6f}) {
      CAPTURE(static_cast<int>(estimator));
      CAPTURE(albedo);
      MediumDescription m = fog(1, albedo);
      std::get<ExtinctionAlbedoDescription>(m.coefficients).sigma_t = SpectrumDescription::rgb(0.2f, 1, 3);
      Description through = wall_behind_cube();
      fill(through, through.shapes.back(), add_medium(through, m));
      Description below = floor_below_cube();
      fill(below, below.shapes.back(), add_medium(below, m));
      through.integrator.medium_estimator = below.integrator.medium_estimator = estimator;
      const Means seen = means_of(through), lit = means_of(below);
      const double sigma[] = {0.2, 1, 3};
      for (int c = 0; c < 3; ++c) {
        check_mean(seen.channel[c], 2 * std::exp(-sigma[c]));
        check_mean(lit.channel[c], kFloor * std::exp(-sigma[c]), 2e-4);
      }
    }
}

TEST_CASE("media: the transmittance of a linear density ramp matches the closed form") {
  const TemporaryFolder folder;
  // Clamped beyond the centers of the outermost voxels, linear in between.
  constexpr int kVoxels = 32;
  const auto file = write_vol(folder / "ramp.vol", kVoxels, 1, [](Vec3f p, int) { return 4 * p.x; });
  const auto upwards = write_vol(folder / "up.vol", kVoxels, 1, [](Vec3f p, int) { return 4 * p.y; });
  for (const MediumEstimator estimator : kUnbiased) {
    CAPTURE(static_cast<int>(estimator));
    Description through = wall_behind_cube();
    fill(through, through.shapes.back(), add_medium(through, with_density(fog(1, 0.5f), vol(file))));
    Description below = floor_below_cube();
    fill(below, below.shapes.back(), add_medium(below, with_density(fog(1, 0.5f), vol(upwards))));
    through.integrator.medium_estimator = below.integrator.medium_estimator = estimator;
    check_gray(through, 2 * std::exp(-2.0));
    const Means lit = means_of(below);
    for (const MeanVariance& channel : lit.channel) check_mean(channel, kFloor * std::exp(-2.0), 2e-4);
  }
}

TEST_CASE("media: ray marching converges to the transmittance of a ramp with first order or better") {
  const TemporaryFolder folder;
  const auto file = write_vol(folder / "ramp.vol", 32, 1, [](Vec3f p, int) { return 12 * p.x * p.x; });
  double error[3];
  for (int i = 0; i < 3; ++i) {
    Description d = wall_behind_cube();
    fill(d, d.shapes.back(), add_medium(d, with_density(fog(1, 0), vol(file))));
    d.integrator.medium_estimator = MediumEstimator::kMarching;
    d.integrator.step_size = 0.5f / static_cast<float>(1 << i);
    error[i] = std::fabs(means_of(d).channel[0].mean() / (2 * std::exp(-4.0)) - 1);
  }
  MESSAGE("relative errors at steps of 1/2, 1/4, 1/8: " << error[0] << ", " << error[1] << ", " << error[2]);
  CHECK(error[0] > 0.05);
  CHECK(error[1] < 0.6 * error[0]);
  CHECK(error[2] < 0.6 * error[1]);
}

namespace {

MediumDescription glowing(float sigma_t, float albedo, float radiance) {
  MediumDescription m = fog(sigma_t, albedo);
  m.emission = VolumeInput(SpectrumDescription::constant(radiance));
  return m;
}

constexpr float kGlowRadius = 0.8f, kGlowHeight = 1.5f;

/// A diffuse floor at z = 0, seen from the side, below a sphere of `medium`.
Description floor_below_glow(const MediumDescription& medium) {
  Description d = small_scene();
  look_at(d, {3, 0, 0.5f}, {0, 0, 0}, {0, 0, 1}, 0.01f);
  d.integrator.max_depth = 2;
  add_rectangle(d, Transform::scale({9, 9, 1}), add_diffuse(d, 0.5f));
  const MediumId id = add_medium(d, medium);
  fill(d, add_sphere(d, {0, 0, kGlowHeight}, kGlowRadius), id);
  return d;
}

/// Radiance that the floor reflects of a sphere that absorbs and emits radiance `emission`: the integral over its cone
/// of emission * (1 - exp(-sigma * chord)).
double reflected_glow(double sigma, double emission) {
  const double sin_max = kGlowRadius / kGlowHeight;
  double sum = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double sin2 = sin_max * sin_max * (i + 0.5) / kSteps;  // the measure cos sin d(angle) equals d(sin^2) / 2
    const double chord = 2 * std::sqrt(kGlowRadius * kGlowRadius - kGlowHeight * kGlowHeight * sin2);
    sum += emission * (1 - std::exp(-sigma * chord));
  }
  return 0.5 * sum / kSteps * sin_max * sin_max;
}

}  // namespace

TEST_CASE("media: an emissive sphere matches the closed form directly and as illumination of a floor") {
  const TemporaryFolder folder;
  const auto one = write_vol(folder / "one.vol", 3, 1, [](Vec3f, int) { return 1.0f; });
  const Transform around = Transform::translate({-4, -4, -4}) * Transform::scale({8, 8, 8});
  for (const float sigma : {0.05f, 1.0f, 6.0f})
    for (const bool on_grid : {false, true})
      for (const MediumEstimator estimator :
           {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio, MediumEstimator::kMarching}) {
        if (estimator == MediumEstimator::kMarching && !on_grid) continue;
        CAPTURE(sigma);
        CAPTURE(on_grid);
        CAPTURE(static_cast<int>(estimator));
        MediumDescription m = glowing(sigma, 0, 3);
        if (on_grid) m.density = vol(one, around);
        Description seen = small_scene();
        aim(seen, {0, 0, -5}, {0, 0, 0});
        const MediumId id = add_medium(seen, m);
        fill(seen, add_sphere(seen, {0, 0, 0}, 0.8f), id);
        seen.integrator.max_depth = 1;
        seen.integrator.medium_estimator = estimator;
        check_gray(seen, 3 * (1 - std::exp(-1.6 * sigma)));
        for (const LightStrategy strategy :
             {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly}) {
          // With ray marching, only paths find emission.
          if (estimator == MediumEstimator::kMarching && strategy != LightStrategy::kBsdfOnly) continue;
          CAPTURE(static_cast<int>(strategy));
          Description d = floor_below_glow(m);
          d.integrator.strategy = strategy;
          d.integrator.medium_estimator = estimator;
          const Means lit = means_of(d);
          for (const MeanVariance& channel : lit.channel) check_mean(channel, reflected_glow(sigma, 3), 2e-4);
        }
      }
}

TEST_CASE("media: an isothermal gas emits as a black body in both color modes") {
  const TemporaryFolder folder;
  const auto half = write_vol(folder / "half.vol", 3, 1, [](Vec3f, int) { return 0.5f; });
  const Transform around = Transform::translate({-2, -2, -2}) * Transform::scale({4, 4, 4});
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    CAPTURE(static_cast<int>(color));
    Means means[2];
    for (const bool on_grid : {false, true}) {
      MediumDescription m = fog(2, 0);
      if (on_grid) {
        m.temperature = vol(half, around);
        m.temperature_scale = 6000;
      } else {
        m.emission = VolumeInput(SpectrumDescription{SpectrumDescription::Blackbody{3000, 1}});
      }
      m.emission_scale = 1e-4f;
      Description d = small_scene();
      aim(d, {0, 0, -5}, {0, 0, 0});
      const MediumId id = add_medium(d, m);
      fill(d, add_sphere(d, {0, 0, 0}, 0.8f), id);
      means[on_grid] = means_of(d, color);
    }
    for (int c = 0; c < 3; ++c) {
      CAPTURE(c);
      const double expected = means[0].channel[c].mean();
      CHECK(expected > 0);
      CHECK(means[1].channel[c].p_value(expected) >= kLevel);
      CHECK(means[1].channel[c].mean() == near(expected, 0.05));
    }
  }
}

TEST_CASE("media: combined light and path sampling of emission has less variance than either alone") {
  MediumDescription m = glowing(1.5f, 0, 3);
  double variance[3];
  for (int i = 0; i < 3; ++i) {
    Description d = floor_below_glow(m);
    // An area light beside the medium, which both strategies find.
    add_area_light_sphere(d, {0, -2, 1}, 0.8f, 1);
    d.sampler.kind = SamplerKind::kIndependent;
    d.integrator.strategy =
        std::array{LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly}[std::size_t(i)];
    variance[i] = means_of(d).channel[0].variance();
  }
  MESSAGE("variance of pixels: both " << variance[0] << ", paths " << variance[1] << ", light sampling "
                                      << variance[2]);
  CHECK(variance[0] < 0.9 * variance[1]);
  CHECK(variance[0] < 0.9 * variance[2]);
}

TEST_CASE("media: a sphere without absorption is invisible in a white environment") {
  const TemporaryFolder folder;
  const auto one = write_vol(folder / "one.vol", 4, 1, [](Vec3f, int) { return 1.0f; });
  const auto lumps = write_vol(folder / "lumps.vol", 16, 1, [](Vec3f p, int) {
    return 1 + std::sin(17 * p.x) * std::sin(13 * p.y + 1) * std::cos(11 * p.z);
  });
  const Transform around = Transform::translate({-1, -1, -1}) * Transform::scale({2, 2, 2});
  for (const MediumEstimator estimator : kUnbiased)
    for (const float depth : {0.1f, 1.0f, 10.0f})
      for (const float g : {-0.8f, 0.0f, 0.8f}) {
        CAPTURE(static_cast<int>(estimator));
        CAPTURE(depth);
        CAPTURE(g);
        std::vector<MediumDescription> media = {fog(depth / 2, 1)};
        if (g == 0.0f) {
          media.push_back(with_density(fog(depth / 2, 1), vol(one, around)));
          media.push_back(with_density(fog(depth / 2, 1), vol(lumps, around)));
        }
        for (const MediumDescription& medium : media)
          for (const LightStrategy strategy :
               {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly}) {
            Description d = furnace(medium, g);
            d.integrator.medium_estimator = estimator;
            d.integrator.strategy = strategy;
            check_gray(d, 1);
          }
      }
}

TEST_CASE("media: homogeneous media and grids have the same mean for every estimator and color") {
  const TemporaryFolder folder;
  const auto one = write_vol(folder / "one.vol", 3, 1, [](Vec3f, int) { return 1.0f; });
  const auto colors = write_vol(folder / "colors.vol", 3, 3, [](Vec3f, int c) {
    return c == 0 ? 0.4f : c == 1 ? 1.2f : 2.5f;
  });
  const Transform around = Transform::translate({-1, -1, -1}) * Transform::scale({2, 2, 2});
  const auto scene = [&](const MediumDescription& medium, MediumEstimator estimator) {
    Description d = small_scene(64);
    look_at(d, {0, 0, -3}, {0, 0, 0}, {0, 1, 0}, 30);
    d.integrator.max_depth = 8;
    d.integrator.medium_estimator = estimator;
    add_area_light_sphere(d, {1.5f, 2, -1.5f}, 0.4f, 20);
    add_rectangle(d, Transform::translate({0, -1, 0}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}),
                  add_diffuse_rgb(d, 0.7f, 0.5f, 0.3f));
    add_sphere(d, {0.2f, 0, 0}, 0.3f, add_glass(d));
    MediumDescription m = medium;
    m.phase = add_phase(d, 0.5f);
    const MediumId id = add_medium(d, m);
    fill(d, add_sphere(d, {0, 0, 0}, 0.9f), id);
    return d;
  };
  MediumDescription plain = fog(1, 0.8f), grid = fog(1, 0.8f), density = fog(1, 0.8f);
  const SpectrumDescription color = SpectrumDescription::rgb(0.4f, 1.2f, 2.5f);
  std::get<ExtinctionAlbedoDescription>(plain.coefficients).sigma_t = color;
  std::get<ExtinctionAlbedoDescription>(density.coefficients).sigma_t = color;
  density.density = vol(one, around);
  MediumDescription sparse = density;
  sparse.density = ones_in_nanovdb(folder / "one.nvdb", 2.2f);
  std::get<ExtinctionAlbedoDescription>(grid.coefficients).sigma_t = vol(colors, around);
  const Means reference = means_of(scene(plain, MediumEstimator::kNullMis));
  for (const MediumDescription& medium : {plain, density, sparse, grid})
    for (const MediumEstimator estimator : kUnbiased) {
      CAPTURE(static_cast<int>(estimator));
      CAPTURE(medium.density.has_value());
      const Means m = means_of(scene(medium, estimator));
      for (int c = 0; c < 3; ++c) {
        CAPTURE(c);
        check_equal(m.channel[c], reference.channel[c]);
      }
    }
}

TEST_CASE("media: emissive scattering media have the same mean for every strategy and estimator") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 16, 1, [](Vec3f p, int) {
    return 1 + std::sin(17 * p.x) * std::sin(13 * p.y + 1) * std::cos(11 * p.z);
  });
  const Transform around = Transform::translate({-1, -1, 0.5f}) * Transform::scale({2, 2, 2});
  const auto scene = [&](bool on_grid, LightStrategy strategy, MediumEstimator estimator) {
    MediumDescription m = glowing(1.5f, 0.6f, 1);
    auto& coefficients = std::get<ExtinctionAlbedoDescription>(m.coefficients);
    coefficients.sigma_t = SpectrumDescription::rgb(0.7f, 1.5f, 3);
    m.emission = VolumeInput(SpectrumDescription::rgb(3, 2, 0.5f));
    if (on_grid) m.density = vol(lumps, around);
    Description d = floor_below_glow(m);
    look_at(d, {4, 0, 1.5f}, {0, 0, 1}, {0, 0, 1}, 40);
    d.media.back().phase = add_phase(d, 0.6f);
    d.integrator.max_depth = 6;
    d.integrator.strategy = strategy;
    d.integrator.medium_estimator = estimator;
    add_point_light(d, {2, 2, 3}, 5);
    if (strategy != LightStrategy::kMis) d.lights.clear();
    return d;
  };
  for (const bool on_grid : {false, true}) {
    const auto strip = [](Description d) {
      d.lights.clear();
      return d;
    };
    const Means reference = means_of(strip(scene(on_grid, LightStrategy::kMis, MediumEstimator::kNullMis)));
    const Means lit = means_of(scene(on_grid, LightStrategy::kMis, MediumEstimator::kNullMis));
    for (const MediumEstimator estimator : kUnbiased) {
      const Means with_point = means_of(scene(on_grid, LightStrategy::kMis, estimator));
      for (int c = 0; c < 3; ++c) check_equal(with_point.channel[c], lit.channel[c]);
      for (const LightStrategy strategy : {LightStrategy::kBsdfOnly, LightStrategy::kLightOnly}) {
        CAPTURE(on_grid);
        CAPTURE(static_cast<int>(estimator));
        CAPTURE(static_cast<int>(strategy));
        const Means m = means_of(scene(on_grid, strategy, estimator));
        for (int c = 0; c < 3; ++c) check_equal(m.channel[c], reference.channel[c]);
      }
    }
    for (const int candidates : {4, 16}) {
      CAPTURE(candidates);
      Description d = scene(on_grid, LightStrategy::kMis, MediumEstimator::kNullMis);
      d.integrator.candidates = candidates;
      const Means m = means_of(d);
      for (int c = 0; c < 3; ++c) check_equal(m.channel[c], lit.channel[c]);
    }
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_media_estimators

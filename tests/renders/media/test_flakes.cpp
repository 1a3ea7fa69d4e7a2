// Renders of microflake media: directional extinction with every estimator, energy, and path against light tracing.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace sheaf::test_flakes {

namespace {

using Matrix = std::array<float, 6>;  ///< xx, yy, zz, xy, xz, yz

/// All comparisons of this file together fail with probability kSignificance if every estimator is unbiased.
const double kLevel = significance_of_each(60);

constexpr MediumEstimator kEstimators[] = {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio,
                                           MediumEstimator::kMarching};

/// Fibers along an oblique axis.
constexpr Matrix kOblique{0.5f, 0.9f, 0.4f, 0.2f, -0.3f, 0.1f};

double area(const Matrix& s, Vec3f w) {
  return std::sqrt(double(s[0] * w.x * w.x + s[1] * w.y * w.y + s[2] * w.z * w.z +
                          2 * (s[3] * w.x * w.y + s[4] * w.x * w.z + s[5] * w.y * w.z)));
}

MeanVariance statistics_of(const Description& d) {
  const Image image = render(*compile_scene(d), {}).to_image();
  MeanVariance mean;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) mean.add(image.at(x, y, 1));
  return mean;
}

void check_mean(const MeanVariance& found, double expected, double rounding) {
  const double distance = found.mean() - expected, allowed = rounding * std::fabs(expected);
  INFO("mean " << found.mean() << ", expected " << expected);
  CHECK(found.p_value(std::fabs(distance) <= allowed ? found.mean() : expected + std::copysign(allowed, distance)) >=
        kLevel);
}

void check_equal(const MeanVariance& a, const MeanVariance& b, int pixels) {
  const double error = std::sqrt((a.variance() + b.variance()) / pixels);
  INFO("means " << a.mean() << " and " << b.mean() << ", standard error " << error);
  CHECK(student_t_p_value((a.mean() - b.mean()) / error, 2 * pixels - 2) >= kLevel);
}

/// Fills the cube [0, 1]^3 with flakes. `grid` gives a matrix for each voxel instead of the constant `s`.
void fill_cube(Description& d, float sigma_t, float albedo, const Matrix& s, const std::filesystem::path& grid = {}) {
  SggxDescription flakes{s};
  if (!grid.empty()) flakes.matrix = vol(grid);
  d.phases.push_back({flakes, {}});
  MediumDescription m = fog(sigma_t, albedo);
  m.phase = static_cast<PhaseId>(d.phases.size() - 1);
  fill(d, add_shape(d, CubeShape{}, Transform::translate({0.5f, 0.5f, 0.5f}) * Transform::scale({0.5f, 0.5f, 0.5f})),
       add_medium(d, m));
}

Description small_scene(int side, int samples, MediumEstimator estimator = MediumEstimator::kNullMis) {
  Description d = empty_scene(side, side);
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  d.sampler.seed = 3;
  d.integrator.medium_estimator = estimator;
  return d;
}

std::filesystem::path write_matrices(const std::filesystem::path& file, const Matrix& low, const Matrix& high) {
  return write_vol(file, 16, 6, [&](Vec3f p, int c) {
    const auto k = static_cast<std::size_t>(c);
    return low[k] + (high[k] - low[k]) * p.x;
  });
}

}  // namespace

TEST_CASE("flakes: transmittance follows the projected area with every estimator") {
  const TemporaryFolder folder;
  const auto grid = write_matrices(folder / "flakes.vol", kOblique, kOblique);
  const Vec3f along = normalize(Vec3f{1, 0.4f, 0.3f});
  const double length = 1 / double(along.x), passed = std::exp(-2 * area(kOblique, along) * length);
  REQUIRE(std::fabs(passed - std::exp(-2 * area(kOblique, {1, 0, 0}) * length)) > 0.01);
  for (const MediumEstimator estimator : kEstimators)
    for (const bool on_grid : {false, true}) {
      CAPTURE(static_cast<int>(estimator));
      CAPTURE(on_grid);
      // Paths see an emissive object behind the cube. Shadow rays connect a wall to a lamp through the cube.
      const Vec3f middle{0.5f, 0.5f, 0.5f}, behind = middle + along * 4.0f, before = middle - along * 4.0f;
      Description through = small_scene(16, 64, estimator);
      through.integrator.max_depth = 1;
      look_at(through, before, middle, {0, 1, 0}, 0.01f);
      add_area_light_sphere(through, behind, 1, 2);
      fill_cube(through, 2, 0.5f, kOblique, on_grid ? grid : std::filesystem::path());
      check_mean(statistics_of(through), 2 * passed, 1e-4);

      Description below = small_scene(16, 64, estimator);
      below.integrator.max_depth = 2;
      look_at(below, behind - Vec3f{0, 3, 0}, behind, {1, 0, 0}, 0.01f);
      add_rectangle(below, Transform::look_at(behind, middle, {0, 1, 0}) * Transform::scale({9, 9, 1}),
                    add_two_sided(below, add_diffuse(below, 0.5f)));
      add_point_light(below, before, 64);
      fill_cube(below, 2, 0.5f, kOblique, on_grid ? grid : std::filesystem::path());
      check_mean(statistics_of(below), 0.5 / 3.14159265358979 * passed, 5e-4);
    }
}

TEST_CASE("flakes: matrices are interpolated between voxels and extinction follows") {
  const TemporaryFolder folder;
  const Matrix low{0.2f, 1, 1, 0, 0, 0}, high{1, 0.5f, 0.5f, 0, 0, 0};
  const auto grid = write_matrices(folder / "flakes.vol", low, high);
  // The integral of sqrt(0.2 + 0.8 x) over x. In the outermost half voxels, the grid is clamped.
  double depth = 0;
  for (int i = 0; i < 1000; ++i)
    depth += 2 * std::sqrt(0.2 + 0.8 * std::clamp((i + 0.5) / 1000, 1.0 / 32, 31.0 / 32)) / 1000;
  for (const MediumEstimator estimator :
       {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio}) {
    Description d = small_scene(32, 128, estimator);
    d.integrator.max_depth = 1;
    look_at(d, {-4, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 0.01f);
    add_area_light_sphere(d, {4, 0.5f, 0.5f}, 1, 2);
    fill_cube(d, 2, 0.5f, low, grid);
    check_mean(statistics_of(d), 2 * std::exp(-depth), 1e-4);
  }
}

TEST_CASE("flakes: flakes without absorption are invisible in a white environment") {
  Description d = small_scene(16, 64);
  look_at(d, {-2, 1.4f, -1}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 20);
  add_constant_light(d, 1);
  d.integrator.rr_depth = 1000;
  fill_cube(d, 3, 1, kOblique);
  check_mean(statistics_of(d), 1, 1e-3);
}

TEST_CASE("flakes: isotropic flakes equal an isotropic medium") {
  const auto scene = [](bool flakes) {
    Description d = small_scene(16, 128);
    look_at(d, {-2, 1.4f, -1}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 20);
    add_point_light(d, {1, 3, -1}, 10);
    // Flakes of half the area, twice as many.
    fill_cube(d, flakes ? 6.0f : 3.0f, 0.8f, {0.25f, 0.25f, 0.25f, 0, 0, 0});
    if (!flakes) d.media.back().phase.reset();
    return statistics_of(d);
  };
  check_equal(scene(true), scene(false), 256);
}

TEST_CASE("flakes: light tracing and all path estimators agree") {
  const TemporaryFolder folder;
  const auto grid = write_matrices(folder / "flakes.vol", kOblique, {0.9f, 0.1f, 0.1f, 0, 0, 0});
  const auto scene = [&](IntegratorKind kind, MediumEstimator estimator, LightStrategy strategy) {
    Description d = small_scene(16, kind == IntegratorKind::kPath ? 96 : 192, estimator);
    look_at(d, {-2, 1.4f, -1}, {0.5f, 0.5f, 0.5f}, {0, 1, 0}, 25);
    add_area_light_sphere(d, {2.5f, 2, -1.5f}, 0.8f, 6);
    d.integrator.kind = kind;
    d.integrator.strategy = strategy;
    d.integrator.max_depth = 4;
    fill_cube(d, 5, 0.9f, kOblique, grid);
    return statistics_of(d);
  };
  using enum LightStrategy;
  const MeanVariance path = scene(IntegratorKind::kPath, MediumEstimator::kNullMis, kMis);
  check_equal(path, scene(IntegratorKind::kLightTracer, MediumEstimator::kNullMis, kMis), 256);
  check_equal(path, scene(IntegratorKind::kPath, MediumEstimator::kNullMis, kBsdfOnly), 256);
  check_equal(path, scene(IntegratorKind::kPath, MediumEstimator::kDelta, kLightOnly), 256);
  check_equal(path, scene(IntegratorKind::kPath, MediumEstimator::kRatio, kMis), 256);
}

}  // namespace sheaf::test_flakes

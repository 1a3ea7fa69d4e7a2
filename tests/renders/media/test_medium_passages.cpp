// Media behind each other, behind surfaces that scatter, and in front of dispersive surfaces: the state that a path or
// shadow ray carries from one to the next.
#include "kernels/media/medium_tracking.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

namespace sheaf::test_medium_passages {

namespace {

constexpr double kPiD = 3.14159265358979323846;

/// A cube of side 1 around `at`, filled with a grid medium.
void add_cloud(Description& d, const std::filesystem::path& ones, Vec3f at, float sigma_t) {
  const Transform position = Transform::translate(at) * Transform::scale({0.5f, 0.5f, 0.5f});
  MediumDescription m = fog(sigma_t, 0.5f);
  m.density = vol(ones, position * Transform::translate({-2, -2, -2}) * Transform::scale({4, 4, 4}));
  const MediumId id = add_medium(d, m);
  fill(d, add_shape(d, CubeShape{}, position), id);
}

}  // namespace

TEST_CASE("medium passages: a cloud behind another attenuates the remaining light") {
  const TemporaryFolder folder;
  const auto ones = write_vol(folder / "ones.vol", 3, 1, [](Vec3f, int) { return 1.0f; });
  constexpr float kSigma[] = {0.7f, 0.9f};
  const double left = std::exp(-double(kSigma[0]) - double(kSigma[1]));
  const MediumEstimator estimators[] = {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio};
  const double level = significance_of_each(3 * 2 * 3);
  for (const MediumEstimator estimator : estimators)
    for (const bool by_path : {true, false}) {
      CAPTURE(static_cast<int>(estimator));
      CAPTURE(by_path);
      Description d = one_point_scene(64);
      d.integrator.medium_estimator = estimator;
      double expected = 0;
      if (by_path) {
        look_at_point(d, {0, 0, 5}, {0, 0, 0}, {0, 1, 0});
        d.integrator.max_depth = 1;
        add_area_light_rectangle(d, Transform::translate({0, 0, -2}), 2);
        expected = 2 * left;
      } else {
        look_at_point(d, {3, 0, -1.5f}, {0, 0, -2});
        d.integrator.max_depth = 2;
        add_rectangle(d, Transform::translate({0, 0, -2}) * Transform::scale({9, 9, 1}), add_diffuse(d, 0.5f));
        add_point_light(d, {0, 0, 4}, 36);
        expected = 0.5 / kPiD * left;
      }
      add_cloud(d, ones, {0, 0, 0}, kSigma[0]);
      add_cloud(d, ones, {0, 0, 1.5f}, kSigma[1]);
      for (const MeanVariance& channel : pixel_means(d)) check_mean(channel, expected, level, 2e-4 * expected);
    }
}

TEST_CASE("medium passages: all strategies agree behind a rough boundary of a medium") {
  Description d = one_point_scene(64);
  look_at_point(d, {1, 0, 3}, {0, 0, 0});
  d.integrator.max_depth = 2;
  DielectricDescription glass;
  glass.int_ior = 1.3f;
  glass.ext_ior = 1;
  glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.5f, 0.5f};
  const MaterialId rough = add_material(d, glass);
  MediumDescription m = fog(1, 0);
  std::get<ExtinctionAlbedoDescription>(m.coefficients).sigma_t = SpectrumDescription::rgb(0.3f, 1, 2);
  SUBCASE("an absorbing medium") {}
  SUBCASE("a scattering medium") {
    std::get<ExtinctionAlbedoDescription>(m.coefficients).albedo = SpectrumDescription::constant(0.8f);
    d.integrator.max_depth = 3;
  }
  const MediumId id = add_medium(d, m);
  add_rectangle(d, Transform::scale({50, 50, 1}), rough).interior = id;
  add_area_light_rectangle(d, Transform::translate({0.3f, 0, -1}) * Transform::scale({0.8f, 0.8f, 1}), 3);
  check_strategies_agree(d, significance_of_each(2 * 9));
}

TEST_CASE("medium passages: colored fog seen through weakly dispersive glass looks as through ordinary glass") {
  PixelMeans means[2];
  for (const bool disperses : {false, true}) {
    Description d = one_point_scene(64);
    d.sampler.seed += disperses;
    look_at_point(d, {0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    d.integrator.max_depth = 2;
    DielectricDescription glass;
    glass.int_ior = 1.5f;
    glass.ext_ior = 1;
    if (disperses) {
      Dispersion& dispersion = glass.int_dispersion.emplace();
      dispersion.form = Dispersion::Form::kPowers;
      dispersion.constant = 1.5f;
      dispersion.terms[0] = {1e-5f, -2};
    }
    add_rectangle(d, Transform::scale({5, 5, 1}), add_material(d, glass));
    add_area_light_rectangle(d, Transform::translate({0, 0, -1}) * Transform::scale({5, 5, 1}), 2);
    MediumDescription m = fog(1, 0.5f);
    std::get<ExtinctionAlbedoDescription>(m.coefficients).sigma_t = SpectrumDescription::rgb(0.3f, 1, 3);
    const MediumId id = add_medium(d, m);
    fill(d, add_shape(d, CubeShape{}, Transform::translate({0, 0, 2}) * Transform::scale({0.5f, 0.5f, 0.5f})), id);
    means[disperses] = pixel_means(d, ColorMode::kSpectral);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    CAPTURE(c);
    check_same_mean(means[0][c], means[1][c], significance_of_each(3));
  }
}

TEST_CASE("medium passages: rescaling the weights of a path by a common factor changes nothing") {
  PathWeights path{Float4(Spectrum4{8e6f, 4e6f, 2e6f, 0}), Float4(Spectrum4{4e6f, 2e6f, 1e6f, 3e6f}),
                   Float4(Spectrum4{2e6f, 1e6f, 8e6f, 1e6f})};
  const PathWeights before = path;
  path.rescale();
  CHECK(max_component(path.r_u) <= 1e6f);
  const float factor = path.r_u[0] / before.r_u[0];
  for (int lane = 0; lane < 4; ++lane) {
    CAPTURE(lane);
    CHECK(path.beta[lane] == near(before.beta[lane] * factor));
    CHECK(path.r_u[lane] == near(before.r_u[lane] * factor));
    CHECK(path.r_l[lane] == near(before.r_l[lane] * factor));
  }
}

}  // namespace sheaf::test_medium_passages

// Density tracking: distances and transmittance against exact values, scalar against SIMD code, and the path weights
// per wavelength.
#include "kernels/media/density_weights.h"

#include "scene/compile/media/make_majorants.h"

#include "tests/support/near.h"
#include "tests/support/statistics.h"
#include "tests/support/volume_testing.h"

#include <memory>

namespace sheaf::test_density_tracking {

using namespace test;

namespace {

constexpr double kLevel = 1e-4;

/// A medium from a noise grid with some empty regions.
struct Noise {
  BrickGrid grid;
  MajorantGrid majorants;
  BrickGridRow density;
  MajorantGridRow bounds;

  Noise(float thickness, bool minorants, float least) {
    std::vector<float> values(24 * 24 * 24);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = i / 24 % 24 < 6 && i % 24 < 8 ? 0.0f : least + (1 - least) * noise(static_cast<std::uint32_t>(i), 5);
    grid = make_dense_grid(1, {24, 24, 24}, values, GridBorder::kClamp);
    majorants = make_majorant_grid(grid, GridFilter::kTrilinear, {thickness, minorants});
    density = make_brick_grid_row(grid, Transform(), GridFilter::kTrilinear);
    bounds = make_majorant_grid_row(majorants, grid, Transform(), GridFilter::kTrilinear);
  }
  Noise(const Noise&) = delete;
  Noise& operator=(const Noise&) = delete;

  /// Optical depth at density 1 along a ray, from its origin to i / kSteps of `length`, by the midpoint rule.
  static constexpr int kSteps = 20000;
  std::vector<double> depths(Vec3f o, Vec3f d, float length) const {
    std::vector<double> found(1, 0.0);
    for (int i = 0; i < kSteps; ++i) {
      const Vec3f p = o + d * (length * (static_cast<float>(i) + 0.5f) / kSteps);
      const float least = std::min({p.x, p.y, p.z}), most = max_component(p);
      const bool is_inside = least >= -0.5f && most <= 23.5f;
      found.push_back(found.back() + (is_inside ? double{lookup_grid(density, p)} * double{length} / kSteps : 0.0));
    }
    return found;
  }
};

/// A number for DensityRay::first that is independent of the ray's other random numbers.
float first_of(const MediumNumbers<Scalar>& n) { return MediumNumbers<Scalar>::start(n.x, n.y, n.z, n.w).at(0).x; }

/// Tracks the same ray `rays` times with different random numbers.
template <class L, DensityTracking kPurpose>
std::vector<TrackResult<Scalar>> track(const Noise& medium, Vec3f o, Vec3f d, float length, float extinction,
                                       int rays) {
  auto rows = std::make_unique<DensityRays>();
  auto ends = std::make_unique<TrackResults>();
  std::vector<TrackResult<Scalar>> found;
  for (std::uint32_t next = 0; found.size() < static_cast<std::size_t>(rays);) {
    for (int i = 0; i < kDensityRows; ++i) {
      const MediumNumbers<Scalar> numbers{next++, 7, 3, 11};
      rows->store<Scalar>(i, {o, d, length, extinction, extinction, first_of(numbers), numbers});
    }
    const int count = std::min(kDensityRows, rays - static_cast<int>(found.size()));
    track_densities<L, kPurpose>({medium.bounds, medium.density}, *rows, count, *ends);
    for (int i = 0; i < count; ++i) found.push_back(ends->load<Scalar>(i));
  }
  return found;
}

bool has_passed(const TrackResult<Scalar>& end) {
  return end.outcome == static_cast<std::uint32_t>(DensityOutcome::kPassed);
}

}  // namespace

TEST_CASE("density tracking: transmittance is unbiased with and without minorants for all leaf sizes") {
  const Vec3f o{-2, 3, 5}, d = normalize(Vec3f{24, 17, 12});
  for (const float thickness : {0.0f, 0.3f, 10.0f})
    for (const float least : {0.0f, 0.6f})
      for (const bool minorants : {false, true}) {
        const Noise medium(thickness, minorants, least);
        for (const float extinction : {0.05f, 0.5f}) {
          const double expected = std::exp(-double{extinction} * medium.depths(o, d, 25).back());
          MeanVariance scattering, transmittance;
          for (const auto& end : track<Wide, DensityTracking::kScattering>(medium, o, d, 25, extinction, 4000))
            scattering.add(has_passed(end) ? 1.0 : 0.0);
          for (const auto& end : track<Wide, DensityTracking::kTransmittance>(medium, o, d, 25, extinction, 4000))
            transmittance.add(has_passed(end) ? std::exp(-double{extinction} * double{end.minorants}) *
                                                    double{end.ratio} * double{end.survival}
                                              : 0.0);
          CAPTURE(thickness);
          CAPTURE(least);
          CAPTURE(minorants);
          CAPTURE(extinction);
          CAPTURE(expected);
          CAPTURE(scattering.mean());
          CAPTURE(transmittance.mean());
          const double count = 4000;
          if (expected > 0.005)
            CHECK(student_t_p_value((scattering.mean() - expected) / std::sqrt(expected * (1 - expected) / count),
                                    count) >= kLevel);
          CHECK(student_t_p_value((transmittance.mean() - expected) /
                                      std::max(std::sqrt(transmittance.variance() / count), 1e-5 * expected),
                                  count) >= kLevel);
        }
      }
}

TEST_CASE("density tracking: distances follow the closed form and weights of light sampling have mean 1") {
  const Noise medium(0.3f, true, 0.5f);
  const Vec3f o{1, 1, 3}, d = normalize(Vec3f{3, 20, 4});
  const float extinction = 0.12f;
  const auto ends = track<Wide, DensityTracking::kScattering>(medium, o, d, 40, extinction, 8000);
  // Compare quantiles: 1 - T(t) is uniform below 1 - T(end).
  const std::vector<double> depths = medium.depths(o, d, 40);
  const double total = depths.back();
  std::vector<double> counts(20);
  MeanVariance light;
  for (const auto& end : ends) {
    const double u =
        has_passed(end) ? 1.0 : -std::expm1(-0.12 * depths[static_cast<std::size_t>(end.t / 40 * Noise::kSteps)]);
    const double position = has_passed(end) ? 19 : u / -std::expm1(-0.12 * total) * 19;
    counts[static_cast<std::size_t>(std::min(position, has_passed(end) ? 19.0 : 18.0))] += 1;
    // The pdf ratio of light sampling and path sampling. Its mean is 1 over the rays that pass.
    light.add(has_passed(end) ? double{end.ratio} * std::exp(0.12 * double{end.minorants}) : 0.0);
  }
  const double n = 8000, passing = std::exp(-0.12 * total);
  double chi = 0;
  for (std::size_t i = 0; i < 20; ++i) {
    const double expected = i == 19 ? n * passing : n * (1 - passing) / 19;
    chi += (counts[i] - expected) * (counts[i] - expected) / expected;
  }
  CAPTURE(chi);
  CHECK(chi < 50.8);  // chi-square quantile for 19 degrees of freedom at 1e-4
  CAPTURE(light.mean());
  CHECK(student_t_p_value((light.mean() - 1) / std::sqrt(light.variance() / n), n) >= kLevel);
}

TEST_CASE("density tracking: weights and pdfs of lanes with unequal extinction match computations by hand") {
  const SceneView scene{};
  MediumRow medium;
  medium.flags = kMediumSingleGrid | kMediumScatters;
  const std::array<double, 4> s = {0.3, 0.8, 0.1, 0.5}, albedo = {0.9, 0.4, 0.6, 0.7};
  MediumSpectra spectra;
  spectra.first = Float4(Spectrum4{0.3f, 0.8f, 0.1f, 0.5f});
  spectra.second = Float4(Spectrum4{0.9f, 0.4f, 0.6f, 0.7f});
  const double majorants = 5, minorants = 2, ratio = 0.7, survival = 2;
  for (const int hero : {0, 1, 3})
    for (const bool weighted : {true, false})
      for (const bool delta : {false, true})
        for (const std::uint32_t nulls : {0u, 1u, 5u}) {
          CAPTURE(hero);
          CAPTURE(weighted);
          CAPTURE(delta);
          CAPTURE(nulls);
          const MediumRay ray{scene, medium, spectra, {}, {}, {0, 0, 1}, 10, hero, weighted};
          TrackResult<Scalar> end{};
          end.t = 4, end.majorants = 5, end.minorants = 2, end.ratio = 0.7f, end.survival = 2, end.nulls = nulls;
          end.outcome = static_cast<std::uint32_t>(DensityOutcome::kPassed);
          const double h = s[static_cast<std::size_t>(hero)];
          PathWeights path{Float4(1.0f), Float4(1.0f), Float4(1.0f)}, light = path, scattered = path;
          weigh_scattering(ray, end, delta, path);
          weigh_transmittance(ray, end, delta, light);
          end.outcome = static_cast<std::uint32_t>(DensityOutcome::kScattered);
          weigh_scattering(ray, end, delta, scattered);
          for (int lane = 0; lane < 4; ++lane) {
            CAPTURE(lane);
            // The lane whose coefficients enter the pdfs: each its own, or the hero wavelength's for all.
            const auto l = static_cast<std::size_t>(lane), d = weighted ? l : static_cast<std::size_t>(hero);
            const auto by_path = [&](double sigma) {
              return std::pow(sigma / h, nulls) * std::exp((h - sigma) * majorants);
            };
            const auto by_light = [&](double sigma) {
              return std::pow(sigma / h, nulls) * std::exp((h - sigma) * (majorants - minorants));
            };
            const auto check = [](float found, double expected) { CHECK(double{found} / expected == near(1, 1e-4)); };
            check(path.beta[lane], by_path(s[l]));
            check(path.r_u[lane], by_path(s[d]));
            check(path.r_l[lane], delta ? by_path(s[d]) : by_light(s[d]) * ratio * std::exp(h * minorants));
            const double passed = delta ? 1 : ratio * std::exp(-h * minorants);
            check(light.beta[lane], by_path(s[l]) * passed * survival);
            check(light.r_u[lane], by_path(s[d]) * passed);
            check(light.r_l[lane], delta ? by_path(s[d]) : by_light(s[d]));
            check(scattered.beta[lane], by_path(s[l]) * s[l] * albedo[l] / h);
            check(scattered.r_u[lane], by_path(s[d]) * s[d] / h);
          }
        }
}

TEST_CASE("density tracking: results do not depend on neighboring rays and SIMD results equal scalar ones") {
  const Noise medium(0.3f, true, 0.2f);
  auto rows = std::make_unique<DensityRays>();
  auto one = std::make_unique<DensityRays>();
  auto ends = std::make_unique<TrackResults>(), alone = std::make_unique<TrackResults>();
  for (int i = 0; i < kDensityRows; ++i) {
    const auto k = static_cast<std::uint32_t>(i);
    const Vec3f o = Vec3f{noise(k, 1), noise(k, 2), noise(k, 3)} * 40 - Vec3f{8, 8, 8};
    const Vec3f target = Vec3f{noise(k, 4), noise(k, 5), noise(k, 6)} * 24;
    const MediumNumbers<Scalar> numbers{k, 1, 2, 3};
    const float extinction = 2 * noise(k, 8) * noise(k, 8);
    rows->store<Scalar>(i, {o, normalize(target - o), 30 * noise(k, 7), extinction, extinction * (1 + noise(k, 9)),
                            first_of(numbers), numbers});
  }
  const auto compare = [&]<DensityTracking kPurpose>() {
    track_densities<Wide, kPurpose>({medium.bounds, medium.density}, *rows, kDensityRows, *ends);
    int same = 0, outcomes[8] = {};
    for (int i = 0; i < kDensityRows; ++i) {
      for (int k = 0; k < kWidth; ++k) one->store<Scalar>(k, {});
      one->store<Scalar>(0, rows->load<Scalar>(i));
      track_densities<Wide, kPurpose>({medium.bounds, medium.density}, *one, 1, *alone);
      TrackResult<Scalar> a = ends->load<Scalar>(i), b = alone->load<Scalar>(0);
      ++outcomes[a.outcome];
      bool is_same = true;
      zip_leaves(a, b, [&](auto& x, auto& y) { is_same = is_same && x == y; });
      CHECK(is_same);
      track_densities<Scalar, kPurpose>({medium.bounds, medium.density}, *one, 1, *alone);
      b = alone->load<Scalar>(0);
      same += a.outcome == b.outcome && a.nulls == b.nulls && std::fabs(a.t - b.t) < 1e-3f &&
              std::fabs(a.ratio - b.ratio) < 1e-3f * std::fabs(b.ratio) + 1e-6f;
    }
    // Logarithms and exponentials round differently, which may change the sampled collisions.
    CHECK(same > kDensityRows * 97 / 100);
    CHECK(outcomes[static_cast<int>(DensityOutcome::kPassed)] > 40);
    return outcomes[static_cast<int>(DensityOutcome::kScattered)] +
           outcomes[static_cast<int>(DensityOutcome::kAbsorbed)];
  };
  CHECK(compare.operator()<DensityTracking::kScattering>() > 20);
  CHECK(compare.operator()<DensityTracking::kTransmittance>() > 5);
}

TEST_CASE("density tracking: rays whose steps vanish in rounding are terminated") {
  Noise medium(0.0f, false, 0.5f);
  // The majorant is this dense although the medium is empty.
  for (MajorantBounds& bounds : medium.majorants.bounds) bounds = MajorantBounds::around(0.0f, 1e30f);
  for (const TrackResult<Scalar>& end :
       {track<Wide, DensityTracking::kScattering>(medium, {-2, 3, 5}, {1, 0, 0}, 9, 1, 1)[0],
        track<Wide, DensityTracking::kTransmittance>(medium, {-2, 3, 5}, {1, 0, 0}, 9, 1, 1)[0]}) {
    CHECK(end.outcome == static_cast<std::uint32_t>(DensityOutcome::kAbandoned));
    CHECK(end.nulls == kMaxCollisions);
  }
}

}  // namespace sheaf::test_density_tracking

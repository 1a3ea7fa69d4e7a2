// Resampled importance sampling of lights: the mean is independent of the number of candidates, and the variance
// decreases.
#include "core/sampling/rng.h"
#include "kernels/lights/light_weight.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"
#include "tests/support/statistics.h"

#include <cmath>
#include <map>

namespace sheaf::test_resample {

namespace {

constexpr int kPaths = 8192;
constexpr double kReflectance = 0.8;
const Vec3f kLights[] = {{0, 0, -1}, {3, 1, 0}, {-2, 2, 1.5f}, {0.5f, -0.2f, 1.2f}, {0, 4, 5}, {-6, 0, 1.9f}};

float intensity(int light) { return 1.0f + 3.0f * static_cast<float>(light % 3); }

/// A square at z = 2 that faces -z, under point lights, one of them behind it.
Description lit_square(int candidates, LightSelector selector) {
  Description d = empty_scene(8, 8);
  add_rectangle(d, Transform::translate({0, 0, 2}) * Transform::rotate({0, 1, 0}, 180),
                add_diffuse(d, static_cast<float>(kReflectance)));
  for (int i = 0; i < static_cast<int>(std::size(kLights)); ++i) add_point_light(d, kLights[i], intensity(i));
  d.integrator.candidates = candidates;
  d.integrator.light_selector = selector;
  d.sampler.kind = SamplerKind::kIndependent;
  return d;
}

/// Reflected radiance at the center of the square, without shadows.
double expected_radiance() {
  double sum = 0;
  for (int i = 0; i < static_cast<int>(std::size(kLights)); ++i) {
    const Vec3f d = kLights[i] - Vec3f{0, 0, 2};
    const double squared = dot(d, d), cosine = std::max(0.0, -d.z / std::sqrt(squared));
    sum += intensity(i) * cosine / squared * kReflectance / 3.14159265358979;
  }
  return sum;
}

/// The contribution of shadow rays over kPaths paths that hit the center of the square.
template <class L> MeanVariance sampled_radiance(const Description& d) {
  const auto scene = compile_scene(d);
  TestWave test(kPaths);
  Wave& wave = test.wave;
  std::map<Slot, double> carried;
  for (int i = 0; i < kPaths; ++i) carried[test.add_active({0, 0, 0}, {0, 0, 1})] = 0;
  intersect<L>(test.context(*scene), wave);
  sort_surfaces<L>(test.context(*scene), wave);
  surface_inputs<L>(test.context(*scene), wave);
  for (int candidate = 0; candidate < *d.integrator.candidates; ++candidate) {
    CHECK(wave.shadow_count == 0);
    light_candidates<L>(test.context(*scene), wave, candidate);
    resample<L>(test.context(*scene), wave, candidate);
  }
  CHECK(test.spare_rows_untouched());
  for (int i = 0; i < wave.shadow_count; ++i) {
    const auto ray = wave.shadows.template load<Scalar>(i);
    carried.at(static_cast<Slot>(ray.slot)) += ray.contribution.c0;
  }
  MeanVariance out;
  for (const auto& [slot, value] : carried) out.add(value);
  return out;
}

}  // namespace

TEST_CASE_TEMPLATE("resample: the mean does not depend on the number of candidates and the variance decreases", L,
                   SHEAF_STAGE_LANES) {
  constexpr int kTests = 3 * 4 * 2;
  for (const LightSelector selector : {LightSelector::kUniform, LightSelector::kPower, LightSelector::kBvh}) {
    double spread = kInfinity;
    for (const int candidates : {1, 2, 8, 64}) {
      CAPTURE(candidates);
      CAPTURE(static_cast<int>(selector));
      const MeanVariance radiance = sampled_radiance<L>(lit_square(candidates, selector));
      CHECK(radiance.p_value(expected_radiance()) > significance_of_each(kTests));
      CHECK(radiance.variance() < 0.75 * spread);
      spread = radiance.variance();
    }
  }
}

TEST_CASE("resample: no candidate is kept if no light is visible") {
  Description d = lit_square(8, LightSelector::kUniform);
  d.lights.clear();
  add_point_light(d, {0, 0, 5}, 1);
  CHECK(sampled_radiance<Wide>(d).mean() == 0.0);
}

TEST_CASE("resample: a single light is chosen by every candidate") {
  Description d = lit_square(1, LightSelector::kUniform);
  d.lights.resize(1);
  const double alone = sampled_radiance<Wide>(d).mean();
  d.integrator.candidates = 16;
  const MeanVariance radiance = sampled_radiance<Wide>(d);
  CHECK(radiance.mean() == near(alone, 1e-5));
  CHECK(radiance.variance() < 1e-10 * alone * alone);
}

// A model in one dimension: light sampling draws M candidates of pdf p(x) = 2x and keeps one; BSDF sampling draws one
// of pdf b(x) = 1.
namespace {

constexpr int kCandidates = 8;
double integrand(double x) { return 1 + std::sin(9 * x) + 4 * x * x * x; }
constexpr double kIntegral = 1 + (1 + 0.91113026188467694) / 9 + 1;  // cos 9 = -0.911...
double p_of(double x) { return 2 * x; }

/// The pdf that represents light sampling in the MIS weights.
enum class Density { kCandidate, kAllCandidates, kKept };

/// The MIS weight of light sampling at x; `kept`: effective pdf of the kept candidate.
double light_fraction(Density density, double x, double kept) {
  const double a = density == Density::kKept ? kept : p_of(x) * (density == Density::kAllCandidates ? kCandidates : 1);
  return power_heuristic(a, 1.0);
}

/// One estimate from both techniques.
double estimate(Density density, std::uint32_t i) {
  // The target omits the MIS weight if that weight depends on the kept candidate.
  const auto target = [&](double x) {
    return integrand(x) * (density == Density::kKept ? 1 : light_fraction(density, x, 0));
  };
  double sum = 0, kept = 0;
  for (int k = 0; k < kCandidates; ++k) {
    const auto u = random4<Scalar>(21, i, static_cast<std::uint32_t>(k), 0);
    const double x = std::sqrt(1.0 - double(u.x)), weight = target(x) / p_of(x);
    sum += weight;
    if (u.y * sum < weight) kept = x;
  }
  const double effective = target(kept) / (sum / kCandidates);
  const double from_lights = integrand(kept) * light_fraction(density, kept, effective) / effective;
  const double x = random4<Scalar>(22, i, 0, 0).x;
  return from_lights +
         integrand(x) * (1 - light_fraction(density == Density::kKept ? Density::kCandidate : density, x, 0));
}

}  // namespace

TEST_CASE("resample: weights by candidate pdfs are unbiased and weights by the kept pdf are not") {
  MeanVariance one, all, kept;
  for (std::uint32_t i = 0; i < 200000; ++i) {
    one.add(estimate(Density::kCandidate, i));
    all.add(estimate(Density::kAllCandidates, i));
    kept.add(estimate(Density::kKept, i));
  }
  CHECK(one.p_value(kIntegral) > significance_of_each(2));
  CHECK(all.p_value(kIntegral) > significance_of_each(2));
  CHECK(all.variance() < one.variance());
  CHECK(kept.p_value(kIntegral) < 1e-9);
}

}  // namespace sheaf::test_resample

// The stages of media on hand-made paths in a homogeneous medium whose coefficients depend on color: the pdfs and
// weights of each lane against closed forms.
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"

#include <array>
#include <cmath>

namespace sheaf::test_stages_media {

namespace {

constexpr int kPaths = 3 * kWidth + 5;
constexpr double kTolerance = 1e-4;
constexpr std::uint32_t kInMedium = 1u << kRayMediumShift;
/// Coefficients, throughput and pdfs at the start of each path; the fourth lane is 0 in RGB mode.
constexpr std::array<double, 3> kScattering{0.2, 0.9, 0.5}, kExtinction{0.3, 1.0, 1.7}, kBeta{0.9, 0.7, 0.4},
    kBefore{1.5, 0.6, 0.8};

Spectrum4 spectrum(const std::array<double, 3>& s) {
  return {static_cast<float>(s[0]), static_cast<float>(s[1]), static_cast<float>(s[2]), 0.0f};
}
std::array<double, 3> values(const Spectrum4& s) { return {double{s.c0}, double{s.c1}, double{s.c2}}; }
double mean(const std::array<double, 3>& s) { return (s[0] + s[1] + s[2]) / 3; }
template <class F> std::array<double, 3> per_lane(F&& f) { return {f(0u), f(1u), f(2u)}; }

/// The medium in the cube [-2, 2]^3 with a point light of intensity 5 in it, and an opaque square at x = 1, z > 1.
std::unique_ptr<Scene> scene_of(MediumEstimator estimator) {
  Description d = empty_scene(4, 4);
  d.integrator.medium_estimator = estimator;
  MediumDescription medium;
  const auto rgb = [](const std::array<double, 3>& s) {
    return SpectrumDescription::rgb(static_cast<float>(s[0]), static_cast<float>(s[1]), static_cast<float>(s[2]));
  };
  medium.coefficients = AbsorptionScatteringDescription{
      rgb(per_lane([](auto k) { return kExtinction[k] - kScattering[k]; })), rgb(kScattering)};
  add_shape(d, CubeShape{}, Transform::scale({2, 2, 2}));
  fill(d, d.shapes.back(), add_medium(d, medium));
  add_rectangle(d, Transform::translate({1, 0, 2}) * Transform::rotate({0, 1, 0}, 90));
  add_point_light(d, {0.3f, 0.8f, 0.2f}, 5);
  return compile_scene(d);
}

/// The lane by whose extinction the estimator samples distances for path `i`.
std::uint32_t hero_of(MediumEstimator estimator, int i) {
  return estimator == MediumEstimator::kNullMis ? static_cast<std::uint32_t>(i % 3) : 2u;
}
/// The lane whose pdf lane `k` has.
std::uint32_t pdf_lane(MediumEstimator estimator, std::uint32_t k) {
  return estimator == MediumEstimator::kNullMis ? k : 2u;
}

/// Adds path `i`: in the medium, with a hit at the distance `t`.
Slot add_path(TestWave& test, int i, float t) {
  const float turn = 0.7f * static_cast<float>(i);
  const Vec3f direction = normalize(Vec3f{std::cos(turn), std::sin(turn), 0.3f});
  const Slot slot = test.add({-0.4f, 0.1f, 0}, direction,
                             kInMedium | static_cast<std::uint32_t>(i % 3) << kRayHeroShift | kRayFromMedium);
  test.wave.paths.row(slot).beta = spectrum(kBeta);
  test.wave.rescaled_pdfs.row(slot) = {spectrum(kBefore), spectrum(kBefore)};
  HitState<Scalar> hit{};
  hit.t = t, hit.shape = 0, hit.instance = hit.light = kNone;
  test.wave.hits.set(slot, hit);
  return slot;
}

const std::array kEstimators{MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio};

}  // namespace

TEST_CASE_TEMPLATE("medium: distances have the pdf of the hero, and the other lanes their own pdfs", L,
                   SHEAF_STAGE_LANES) {
  for (const MediumEstimator estimator : kEstimators) {
    CAPTURE(static_cast<int>(estimator));
    const auto scene = scene_of(estimator);
    TestWave test(kPaths);
    Wave& wave = test.wave;
    std::vector<Slot> slots;
    for (int i = 0; i < kPaths; ++i) wave.medium.push(slots.emplace_back(add_path(test, i, 1.2f)));
    medium<L>(test.context(*scene), wave);
    CHECK(wave.medium.empty());
    check_conservation(wave);
    int scattered = 0;
    for (int i = 0; i < kPaths; ++i) {
      CAPTURE(i);
      const Slot slot = slots[static_cast<std::size_t>(i)];
      const double t = double{wave.hits.row(slot).t};
      const bool scatters = t < 1.19;
      const std::uint32_t hero = hero_of(estimator, i);
      scattered += scatters;
      const auto passed = per_lane([&](auto k) { return std::exp(-kExtinction[k] * t); });
      const auto pdf = per_lane([&](auto k) { return passed[k] * (scatters ? kExtinction[k] : 1.0); });
      const auto beta = values(wave.paths.row(slot).beta), r_u = values(wave.rescaled_pdfs.row(slot).r_u),
                 r_l = values(wave.rescaled_pdfs.row(slot).r_l);
      for (const std::uint32_t k : {0u, 1u, 2u}) {
        CAPTURE(k);
        CHECK(beta[k] == near(kBeta[k] * passed[k] * (scatters ? kScattering[k] : 1.0) / pdf[hero], kTolerance));
        CHECK(r_u[k] == near(kBefore[k] * pdf[pdf_lane(estimator, k)] / pdf[hero], kTolerance));
        CHECK(r_l[k] == near(kBefore[k] / (scatters ? 1.0 : pdf[hero]), kTolerance));
      }
      if (scatters) {
        const SegmentState<Scalar>& segment = wave.segments.row(slot);
        CHECK(segment.length == near(1.2));
        CHECK(double{segment.pdf_ratio} == near(mean(kBefore) / (pdf[hero] * mean(r_u)), kTolerance));
      }
    }
    CHECK(scattered > kPaths / 4);
    CHECK(scattered < kPaths);
  }
}

TEST_CASE_TEMPLATE("segment lights: shadow rays have the weights of paths that scatter there by chance", L,
                   SHEAF_STAGE_LANES) {
  for (const MediumEstimator estimator : kEstimators) {
    CAPTURE(static_cast<int>(estimator));
    const auto scene = scene_of(estimator);
    TestWave test(kPaths);
    Wave& wave = test.wave;
    for (int i = 0; i < kPaths; ++i) wave.medium.push(add_path(test, i, 2.0f));
    segment_lights<L>(test.context(*scene), wave);
    CHECK(wave.medium.size() == kPaths);
    CHECK(wave.shadow_count > kPaths / 2);
    for (int i = 0; i < wave.shadow_count; ++i) {
      CAPTURE(i);
      const ShadowItem<Scalar> shadow = wave.shadows.template load<Scalar>(i);
      const TransmittanceItem<Scalar> state = wave.transmittances.template load<Scalar>(i);
      const RayState<Scalar> ray = wave.rays.get(static_cast<Slot>(shadow.slot));
      const double t = double{dot(shadow.origin - ray.origin, ray.direction)};
      const auto passed = per_lane([&](auto k) { return std::exp(-kExtinction[k] * t); });
      const auto pdf = per_lane([&](auto k) {
        const std::uint32_t of = pdf_lane(estimator, k);
        return kBefore[k] * kExtinction[of] * passed[of];
      });
      const auto r_u = values(state.r_u), r_l = values(state.r_l), found = values(shadow.contribution);
      for (const std::uint32_t k : {0u, 1u, 2u}) {
        CAPTURE(k);
        CHECK(r_u[k] == near(pdf[k] * mean(kBefore) / mean(pdf), kTolerance));
        CHECK(r_l[k] == r_u[k]);
        CHECK(found[k] / found[0] ==
              near(kBeta[k] * kScattering[k] * passed[k] / (kBeta[0] * kScattering[0] * passed[0]), kTolerance));
      }
    }
  }
}

TEST_CASE_TEMPLATE("transmittance: contributions are attenuated and weighted up to their ends", L, SHEAF_STAGE_LANES) {
  struct Case {
    Vec3f origin, direction;
    bool in_medium;
    double length;  ///< in the medium, m; negative: blocked
  };
  // Inside of the medium, out of it, into it, past it, across it, and through the square
  const Case cases[] = {{{-0.4f, 0.1f, 0}, {1.0f, 0.5f, 0.2f}, true, std::sqrt(1.29)},
                        {{0, 0.1f, 0}, {0, 4, 0}, true, 1.9},
                        {{-3, 0.1f, 0}, {3, 0, 0}, false, 2},
                        {{-3, 0.1f, 3}, {4, 0, 0}, false, 0},
                        {{-3, 0.1f, -0.5f}, {0, 0, 1}, false, 0},
                        {{0.5f, -3, 0.2f}, {0, 7, 0}, false, 4},
                        {{0.5f, 0, 1.5f}, {2, 0, 0}, true, -1}};
  const std::array<double, 3> kContribution{2, 3, 1.5}, kByLight{1.2, 0.9, 0.5};
  const double pdf_ratio = 0.8;
  for (const MediumEstimator estimator : kEstimators) {
    CAPTURE(static_cast<int>(estimator));
    const auto scene = scene_of(estimator);
    TestWave test(kPaths);
    Wave& wave = test.wave;
    std::vector<Slot> slots;
    for (int i = 0; i < kPaths; ++i) {
      const Case& c = cases[i % static_cast<int>(std::size(cases))];
      const Slot slot = add_path(test, i, 1);
      wave.surface.push(slot);
      slots.push_back(slot);
      const std::uint32_t hero = static_cast<std::uint32_t>(i % 3) << kRayHeroShift;
      wave.shadows.template store<Scalar>(i, {c.origin, c.direction, spectrum(kContribution), slot, 0});
      wave.transmittances.template store<Scalar>(i,
                                                 {spectrum(kBefore), spectrum(kByLight), static_cast<float>(pdf_ratio),
                                                  hero | (c.in_medium ? kInMedium : 0u), kNone});
    }
    wave.shadow_count = kPaths;
    transmittance<L>(test.context(*scene), wave);
    CHECK(wave.shadow_count == 0);
    check_conservation(wave);
    for (int i = 0; i < kPaths; ++i) {
      CAPTURE(i);
      const Case& c = cases[i % static_cast<int>(std::size(cases))];
      const auto passed = per_lane([&](auto k) { return std::exp(-kExtinction[k] * c.length); });
      const auto r_u = per_lane([&](auto k) { return kBefore[k] * passed[pdf_lane(estimator, k)]; });
      const double by_light = mean(kByLight), by_path = mean(r_u) * pdf_ratio;
      const double weight = by_light * by_light / (by_light * by_light + by_path * by_path) / by_light;
      const auto found = values(wave.radiance.row(slots[static_cast<std::size_t>(i)]).radiance);
      for (const std::uint32_t k : {0u, 1u, 2u}) {
        CAPTURE(k);
        CHECK(found[k] == near(c.length < 0 ? 0.0 : kContribution[k] * passed[k] * weight, kTolerance));
      }
    }
  }
}

}  // namespace sheaf::test_stages_media

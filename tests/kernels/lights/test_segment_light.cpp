// The choice of lights for segments of rays, equiangular sampling, and the lobes towards lights: probabilities and pdfs
// against frequencies and integrals.
#include "core/soa/lane_array.h"
#include "kernels/guiding/glow_lobes.h"
#include "kernels/lights/segment_light.h"
#include "tests/support/near.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

namespace sheaf::test_segment_light {

namespace {

constexpr double kPiD = 3.14159265358979323846;

class Numbers {
 public:
  float uniform(float low = 0, float high = 1) {
    return std::min(std::uniform_real_distribution<float>(low, high)(random_), std::nextafter(high, low));
  }
  Vec3f point(float extent) { return {uniform(-extent, extent), uniform(-extent, extent), uniform(-extent, extent)}; }
  Vec3f direction() {
    std::normal_distribution<float> normal;
    return normalize(Vec3f{normal(random_), normal(random_), normal(random_)});
  }

 private:
  std::mt19937 random_{11};
};

/// Lights of all sizes and powers; every seventh has no power.
LightTree lamps(int count, Numbers& numbers) {
  std::vector<LightBounds> lights;
  for (int i = 0; i < count; ++i) {
    const Vec3f center = numbers.point(5);
    const float half = i % 3 == 0 ? 0.0f : std::exp(numbers.uniform(-6, -1));
    LightBounds light;
    light.lower = center - Vec3f{half, half, half}, light.upper = center + Vec3f{half, half, half};
    light.power = i % 7 == 6 ? 0.0f : std::exp(numbers.uniform(-3, 3));
    lights.push_back(light);
  }
  return build_light_tree(lights);
}

template <class F> float first_of(F values) { return LaneArray<F>(values)[0]; }

RaySegment<Scalar> random_segment(Numbers& numbers) {
  return {numbers.point(5), numbers.direction(), std::exp(numbers.uniform(-2, 4))};
}

}  // namespace

TEST_CASE("segment lights: frequencies equal the probabilities, which add up to that of connecting") {
  for (const int count : {1, 5, 60}) {
    CAPTURE(count);
    Numbers numbers;
    const LightTree tree = lamps(count, numbers);
    const LightTreeView view = tree.view();
    for (int trial = 0; trial < 4; ++trial) {
      const RaySegment<Scalar> segment = random_segment(numbers);
      constexpr int kSamples = 20000;
      std::vector<int> frequency(static_cast<std::size_t>(count));
      int far = 0;
      for (int i = 0; i < kSamples; ++i) {
        const SegmentLight<Scalar> chosen =
            choose_segment_light<Scalar>(view, segment, (static_cast<float>(i) + numbers.uniform()) / kSamples);
        if (!(chosen.probability > 0)) {
          ++far;
          continue;
        }
        ++frequency[chosen.light];
        const SegmentLight<Scalar> found = find_segment_light<Scalar>(view, segment, chosen.light, true);
        REQUIRE(found.probability == near(chosen.probability, 1e-5));
        REQUIRE(found.density.pdf(1) == near(chosen.density.pdf(1), 1e-5));
      }
      double sum = 0;
      for (std::uint32_t light = 0; light < static_cast<std::uint32_t>(count); ++light) {
        const double probability = find_segment_light<Scalar>(view, segment, light, true).probability;
        sum += probability;
        // The numbers are stratified.
        CHECK(std::fabs(frequency[light] - kSamples * probability) <= 3 + 1e-3 * kSamples * probability);
      }
      // The rest is the probability of lights that are too far away.
      CHECK(std::fabs(kSamples * (1 - sum) - far) <= 3 + 1e-3 * far);
    }
  }
}

TEST_CASE("segment lights: lanes are independent") {
  Numbers numbers;
  const LightTree tree = lamps(40, numbers);
  const LightTreeView view = tree.view();
  for (int trial = 0; trial < 200; ++trial) {
    RaySegment<Scalar> segments[kWidth];
    LaneArray<WideFloat> u, words[7];
    for (int lane = 0; lane < kWidth; ++lane) {
      const RaySegment<Scalar>& s = segments[lane] = random_segment(numbers);
      u[lane] = numbers.uniform();
      const float of_lane[] = {s.p.x, s.p.y, s.p.z, s.direction.x, s.direction.y, s.direction.z, s.length};
      for (int k = 0; k < 7; ++k) words[k][lane] = of_lane[k];
    }
    const auto distances = [&](const RaySegment<Wide>& segment, WideFloat number) {
      const SegmentLight<Wide> chosen = choose_segment_light<Wide>(view, segment, number);
      const WideFloat t = chosen.density.sample(number);
      return LaneArray<WideFloat>(t + chosen.density.pdf(t) * chosen.probability);
    };
    const auto together = distances({{words[0].load(), words[1].load(), words[2].load()},
                                     {words[3].load(), words[4].load(), words[5].load()},
                                     words[6].load()},
                                    u.load());
    for (int lane = 0; lane < kWidth; ++lane) {
      const RaySegment<Scalar>& s = segments[lane];
      const auto alone =
          distances({broadcast<Wide>(s.p), broadcast<Wide>(s.direction), WideFloat(s.length)}, WideFloat(u[lane]));
      REQUIRE(alone[lane] == together[lane]);
    }
  }
}

TEST_CASE("segment lights: distances follow their pdf, which integrates to one") {
  Numbers numbers;
  for (int trial = 0; trial < 200; ++trial) {
    const LightTree tree = lamps(1, numbers);
    const RaySegment<Scalar> segment = random_segment(numbers);
    const EquiangularDensity<Scalar> density = choose_segment_light<Scalar>(tree.view(), segment, 0.5f).density;
    // The pdf integrates to u from 0 to the distance of u. Substituting the angle keeps the integrand smooth.
    for (const float u : {0.1f, 0.5f, 0.9f, kOneMinusEpsilon}) {
      const double t = density.sample(u), height = density.height, middle = density.middle;
      const double first = std::atan(-middle / height), last = std::atan((t - middle) / height);
      constexpr int kSteps = 400;
      double sum = 0;
      for (int i = 0; i < kSteps; ++i) {
        const double tangent = std::tan(first + (last - first) * (i + 0.5) / kSteps);
        sum += double{density.pdf(static_cast<float>(middle + height * tangent))} * height * (1 + tangent * tangent);
      }
      CHECK(sum * (last - first) / kSteps == near(u, 2e-3));
    }
  }
}

TEST_CASE("segment lights: points lie in the beam of a light, and all points in the beam can be chosen") {
  Numbers numbers;
  int connected = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    LightBounds light;
    light.lower = light.upper = numbers.point(3);
    light.axis = numbers.direction();
    light.cos_theta_o = 1, light.cos_theta_e = std::cos(numbers.uniform(0.05f, 1.5f));
    light.power = 1;
    const LightTree tree = build_light_tree({&light, 1});
    const RaySegment<Scalar> segment = random_segment(numbers);
    const SegmentLight<Scalar> found = find_segment_light<Scalar>(tree.view(), segment, 0, true);
    const EquiangularDensity<Scalar>& points = found.density;
    CAPTURE(trial);
    if (found.probability > 0) {
      ++connected;
      REQUIRE(points.low >= 0);
      REQUIRE(points.high <= segment.length);
    }
    // Rounding moves the cone and its apex.
    constexpr double kAngle = 0.02, kDistance = 0.05;
    for (int i = 0; i < 200; ++i) {
      const float t = segment.length * (static_cast<float>(i) + 0.5f) / 200;
      const Vec3f d = segment.p + segment.direction * t - light.lower;
      const double distance = length(d), edge = std::acos(double{light.cos_theta_e});
      const double angle = std::acos(std::clamp(double{dot(d, light.axis)} / distance, -1.0, 1.0));
      const double margin = kAngle + kDistance / distance;
      const bool chosen = t >= points.low && t <= points.high && points.high > points.low;
      CAPTURE(t);
      if (angle < edge - margin) REQUIRE(chosen);
      if (angle > edge + margin) REQUIRE(!chosen);
    }
  }
  CHECK(connected > 200);
}

TEST_CASE_TEMPLATE("glow lobes: directions follow their pdf, which integrates to one", L, Scalar, Wide) {
  Numbers numbers;
  const LightTree tree = lamps(9, numbers);
  const LightTreeView view = tree.view();
  REQUIRE(view.glow_source_count > 3);
  const double level = significance_of_each(3 * 3);
  for (int trial = 0; trial < 3; ++trial) {
    const Vec3<L> p = broadcast<L>(numbers.point(5));
    const Float<L> extinction(0.1f * static_cast<float>(trial));
    const float bsdf_probability =
        first_of(evaluate_glow<L>(view, p, extinction, broadcast<L>({0, 0, 1})).bsdf_probability);
    REQUIRE(bsdf_probability >= 1 - kGlowProbability);
    REQUIRE(bsdf_probability < 1);
    // Means over guided directions of f / pdf for functions of known integral
    MeanVariance means[3];
    for (int i = 0; i < 40000; ++i) {
      const Random4<L> u{Float<L>(numbers.uniform(bsdf_probability)), Float<L>(numbers.uniform()),
                         Float<L>(numbers.uniform()), Float<L>(0.0f)};
      const GuideSample<L> sample = sample_glow<L>(view, p, extinction, u);
      const GuideValue<L> value = evaluate_glow<L>(view, p, extinction, sample.direction);
      REQUIRE(first_of(value.bsdf_probability) == bsdf_probability);
      const double pdf = first_of(value.pdf_solid_angle), x = first_of(sample.direction.x),
                   z = first_of(sample.direction.z);
      REQUIRE(pdf > 0);
      means[0].add(1 / pdf);
      means[1].add(x > 0 ? 1 / pdf : 0);
      means[2].add(z * z / pdf);
    }
    CHECK(means[0].p_value(4 * kPiD) >= level);
    CHECK(means[1].p_value(2 * kPiD) >= level);
    CHECK(means[2].p_value(4 * kPiD / 3) >= level);
  }
}

TEST_CASE("glow lobes: vertices outside of fog sample their BSDF only") {
  Numbers numbers;
  const LightTree tree = lamps(3, numbers);
  const GuideSample<Scalar> sample = sample_glow<Scalar>(tree.view(), {0, 0, 0}, -1, {0.9f, 0.5f, 0.5f, 0});
  CHECK(!sample.taken);
  CHECK(sample.bsdf_u == 0.9f);
  const GuideValue<Scalar> value = evaluate_glow<Scalar>(tree.view(), {0, 0, 0}, -1, {0, 0, 1});
  CHECK(value.bsdf_probability == 1);
  CHECK(value.pdf_solid_angle == 0);
}

}  // namespace sheaf::test_segment_light

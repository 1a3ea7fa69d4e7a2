// Lobes towards lights: directions against their pdf, and the choice between lobes and BSDF.
#include "kernels/guiding/glow_lobes.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace sheaf::test_glow_lobes {

namespace {

LightTreeView lights(std::initializer_list<GlowSource> sources) {
  LightTreeView tree{};
  for (const GlowSource& source : sources) tree.glow_sources[tree.glow_source_count++] = source;
  return tree;
}

/// 1 - cos of the angle between `w` and the z axis.
double versine(Vec3f w) { return double{w.x * w.x + w.y * w.y} / (1.0 + double{w.z}); }

}  // namespace

TEST_CASE("glow lobes: directions have the pdf of the lobe, from its center to its back") {
  for (const float radius : {0.0f, 0.5f}) {
    CAPTURE(radius);
    const LightTreeView tree = lights({{{1, 2, 5}, radius, 3}});
    const Vec3f p{1, 2, 1};
    for (double x = 0.05; x < 0.99; x += 0.01) {
      CAPTURE(x);
      const auto sample = [&](double u) {
        return sample_glow<Scalar>(tree, p, 0.0f, {0.9f, static_cast<float>(u), 0.3f, 0.0f});
      };
      const double h = 0.002;
      const GuideSample<Scalar> at = sample(x);
      REQUIRE(at.taken);
      const double slope = (versine(sample(x + h).direction) - versine(sample(x - h).direction)) / (2 * h);
      const GuideValue<Scalar> value = evaluate_glow<Scalar>(tree, p, 0.0f, at.direction);
      // A ring of the sphere has the area 2 pi dc.
      CHECK(double{value.pdf_solid_angle} * 2 * std::numbers::pi * slope == near(1, 0.01));
    }
  }
}

TEST_CASE("glow lobes: lights are chosen by power over distance and by the transmittance of the fog") {
  const LightTreeView tree = lights({{{0, 0, 2}, 0, 1}, {{0, 0, -4}, 0, 6}});
  const float extinction = 0.4f;
  const double first = 1.0 / 2 * std::exp(-0.8), second = 6.0 / 4 * std::exp(-1.6);
  const double transmittance = (first + second) / (1.0 / 2 + 6.0 / 4);
  int lobes = 0, to_first = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const float u = (static_cast<float>(i) + 0.5f) / kCount;
    const GuideSample<Scalar> s = sample_glow<Scalar>(tree, {}, extinction, {u, 0.01f, 0.3f, 0.0f});
    lobes += s.taken;
    to_first += s.taken && s.direction.z > 0;
    if (!s.taken) CHECK(s.bsdf_u < 1.0f);
  }
  CHECK(static_cast<double>(lobes) / kCount == within(double{kGlowProbability} * transmittance, 1e-3));
  CHECK(static_cast<double>(to_first) / lobes == within(first / (first + second), 1e-3));
  const GuideValue<Scalar> value = evaluate_glow<Scalar>(tree, {}, extinction, {0, 0, 1});
  CHECK(double{value.bsdf_probability} == near(1 - double{kGlowProbability} * transmittance, 1e-4));
  // Outside of fog, the BSDF alone is sampled.
  CHECK(!sample_glow<Scalar>(tree, {}, -1.0f, {0.99f, 0.5f, 0.5f, 0.0f}).taken);
  CHECK(evaluate_glow<Scalar>(tree, {}, -1.0f, {0, 0, 1}).bsdf_probability == 1.0f);
}

}  // namespace sheaf::test_glow_lobes

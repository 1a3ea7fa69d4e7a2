// Dispersive dielectrics. With equal indices they match ordinary dielectrics; otherwise tests cover energy, sampling
// and Snell's law at each wavelength.
#include "kernels/bsdf/dielectric.h"
#include "kernels/bsdf/dispersive_dielectric.h"
#include "kernels/bsdf/dispersive_rough_dielectric.h"
#include "kernels/bsdf/rough_dielectric.h"
#include "kernels/bsdf/thin_dielectric.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_dispersive {

namespace {

const Spectrum4 kIndices{1.5f, 1.55f, 1.6f, 1.7f};
constexpr int kSamplingTests = 2 * 2 * 10;

template <template <class> class Bsdf> Bsdf<Scalar> smooth(const Spectrum4& eta, float r = 1, float t = 1) {
  Bsdf<Scalar> bsdf;
  bsdf.eta = eta;
  bsdf.reflectance = Spectrum4(r);
  bsdf.transmittance = Spectrum4(t);
  return bsdf;
}

template <template <class> class Bsdf> Bsdf<Scalar> rough(const Spectrum4& eta, float alpha, float r = 1, float t = 1) {
  Bsdf<Scalar> bsdf = smooth<Bsdf>(eta, r, t);
  bsdf.alpha_u = bsdf.alpha_v = alpha;
  return bsdf;
}

/// The four values rotated by `by`, which makes another one the first.
Spectrum4 rotated(const Spectrum4& s, int by) {
  const float v[4] = {s.c0, s.c1, s.c2, s.c3};
  const auto at = [&](int k) { return v[(k + by) % 4]; };
  return {at(0), at(1), at(2), at(3)};
}

/// Mean scattered power of all wavelengths together, over samples and over the choice of the first wavelength.
template <class Make> MeanVariance scattered_power(Make&& make, Vec3f wo) {
  MeanVariance power;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto s = make(rotated(kIndices, static_cast<int>(i % 4))).sample(wo, lane_random(31, i / 4, 0));
    power.add(s.valid ? 0.25 * double(total(s.weight)) * s.eta_scale : 0.0);
  }
  return power;
}

/// Mean scattered power with each wavelength on its own.
template <class Make> MeanVariance separate_power(Make&& make, Vec3f wo) {
  MeanVariance power;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const Spectrum4 alone(rotated(kIndices, static_cast<int>(i % 4)).c0);
    const auto s = make(alone).sample(wo, lane_random(32, i / 4, 0));
    power.add(s.valid ? double(s.weight.c0) * s.eta_scale : 0.0);
  }
  return power;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("dispersion: a smooth boundary with equal indices is an ordinary dielectric") {
  const auto bsdf = smooth<DispersiveDielectricBsdf>(Spectrum4(1.6f), 0.75f, 0.5f);
  DielectricBsdf<Scalar> plain;
  plain.eta = 1.6f;
  plain.reflectance = Spectrum4(0.75f);
  plain.transmittance = Spectrum4(0.5f);
  for (const Vec3f wo : outgoing_directions())
    for (std::uint32_t i = 0; i < 50; ++i) {
      const auto u = lane_random(33, i, 0);
      const auto s = bsdf.sample(wo, u), expected = plain.sample(wo, u);
      CHECK(s.valid == expected.valid);
      CHECK(record_difference<Vec3>(s.wi, expected.wi) < 1e-6);
      CHECK(record_difference<Spectrum>(s.weight, expected.weight) < 1e-4);
      CHECK(s.eta_scale == near(expected.eta_scale));
    }
}

TEST_CASE("dispersion: refraction keeps the hero wavelength with weight four and reflection keeps all four") {
  const auto bsdf = smooth<DispersiveDielectricBsdf>(kIndices);
  const Vec3f wo = direction_of(0.6, 1);
  const auto through = bsdf.sample(wo, {0.9999f, 0, 0, 0}), back = bsdf.sample(wo, {0, 0, 0, 0});
  const auto fresnel = fresnel_dispersive<Scalar>(wo.z, kIndices);
  CHECK(through.wi.z < 0);
  CHECK(std::hypot(through.wi.x, through.wi.y) == near(std::hypot(wo.x, wo.y) / 1.5, 1e-5));
  CHECK(through.weight.c1 == 0);
  CHECK(through.weight.c2 == 0);
  CHECK(through.weight.c3 == 0);
  CHECK(through.weight.c0 * through.eta_scale * (1 - fresnel.probability) ==
        near(4 * (1 - fresnel.first.reflectance), 1e-4));
  CHECK(back.wi.z == wo.z);
  CHECK(back.weight.c3 * fresnel.probability == near(fresnel_dielectric<Scalar>(wo.z, 1.7f).reflectance));
}

TEST_CASE("dispersion: smooth and thin and rough boundaries conserve energy from both sides") {
  for (const Vec3f wo : outgoing_directions()) {
    CAPTURE(wo.z);
    const auto check = [&](auto&& make, double expected) {
      const MeanVariance power = scattered_power(make, wo);
      const double error = std::sqrt(power.variance() / 20000) + 1e-5;
      CHECK(std::fabs(power.mean() - expected) < 4.5 * error);
    };
    check([](const Spectrum4& eta) { return smooth<DispersiveDielectricBsdf>(eta); }, 1);
    check([](const Spectrum4& eta) { return smooth<DispersiveThinDielectricBsdf>(eta); }, 1);
    if (std::fabs(wo.z) < 0.01f) continue;
    const auto make = [](const Spectrum4& eta) { return rough<DispersiveRoughDielectricGgxBsdf>(eta, 0.3f); };
    const MeanVariance separate = separate_power(make, wo);
    const MeanVariance power = scattered_power(make, wo);
    CHECK(std::fabs(power.mean() - separate.mean()) <
          4.5 * std::sqrt((power.variance() + separate.variance()) / 20000) + 1e-5);
  }
}

TEST_CASE("dispersion: samples of rough boundaries have consistent pdfs and weights") {
  for (const float alpha : {0.3f, 1.0f}) {
    const auto ggx = rough<DispersiveRoughDielectricGgxBsdf>(kIndices, alpha, 0.75f, 0.5f);
    const auto beckmann = rough<DispersiveRoughDielectricBeckmannBsdf>(kIndices, alpha, 0.75f, 0.5f);
    check_bsdf_sampling_with_edges(ggx, kSamplingTests);
    check_bsdf_sampling_with_edges(beckmann, kSamplingTests);
    check_bsdf_weights(ggx, 5e-4);
    check_bsdf_weights(beckmann, 5e-4);
    check_bsdf_finite(ggx);
    check_bsdf_finite(beckmann);
  }
}

TEST_CASE("dispersion: SIMD results equal scalar ones") {
  const auto eta_of = [](int lane) {
    return lane % 3 == 0 ? Spectrum4(1.5f) : Spectrum4{1.3f + 0.02f * static_cast<float>(lane), 1.4f, 1.5f, 1.6f};
  };
  check_bsdf_lanes<DispersiveDielectricBsdf>([&](int lane) { return smooth<DispersiveDielectricBsdf>(eta_of(lane)); });
  check_bsdf_lanes<DispersiveThinDielectricBsdf>(
      [&](int lane) { return smooth<DispersiveThinDielectricBsdf>(eta_of(lane)); });
  check_bsdf_lanes<DispersiveRoughDielectricGgxBsdf>([&](int lane) {
    return rough<DispersiveRoughDielectricGgxBsdf>(eta_of(lane), 0.2f + 0.04f * static_cast<float>(lane));
  });
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_dispersive

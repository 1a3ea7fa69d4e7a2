// What every BSDF is put to: chi-square of its samples, energy, reciprocity, and registers against single values.
#pragma once

#include "kernels/bsdf/bsdf.h"
#include "tests/chi_square.h"
#include "tests/records_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace sheaf {

inline Vec3f direction_of(double cos_theta, double phi) {
  const double sin_theta = std::sqrt(std::max(0.0, 1 - cos_theta * cos_theta));
  return {static_cast<float>(sin_theta * std::cos(phi)), static_cast<float>(sin_theta * std::sin(phi)),
          static_cast<float>(cos_theta)};
}

/// Outgoing directions from normal to grazing incidence, on both sides of the surface.
inline std::vector<Vec3f> outgoing_directions() {
  std::vector<Vec3f> out;
  for (const double c : {1.0, 0.8, 0.4, 0.05, 0.001})
    for (const double side : {1.0, -1.0}) out.push_back(direction_of(side * c, 0.7 + 2.0 * c));
  return out;
}

template <class Bsdf> bool scatters(const Bsdf& bsdf, Vec3f wo) {
  for (std::uint32_t i = 0; i < 64; ++i)
    if (bsdf.sample(wo, lane_random(9, i, 0)).valid) return true;
  return false;
}

/// Samples of a BSDF that is not specular, from every direction of outgoing_directions(), follow its pdf, which
/// integrates to the share of draws that produce a direction. `tests`: how many tests share the significance level.
template <class Bsdf> void check_bsdf_sampling(const Bsdf& bsdf, int tests) {
  for (const Vec3f wo : outgoing_directions()) {
    CAPTURE(wo.z);
    const auto sample = [&](Random4<Scalar> u) -> std::optional<Vec3f> {
      const auto s = bsdf.sample(wo, u);
      return s.valid ? std::optional<Vec3f>(s.wi) : std::nullopt;
    };
    const auto pdf = [&](Vec3f wi) { return static_cast<double>(bsdf.pdf_solid_angle(wo, wi)); };
    if (!scatters(bsdf, wo)) {
      for (std::uint32_t i = 0; i < 100; ++i) {
        const Vec3f wi = random_direction(11, i);
        CHECK(bsdf.pdf_solid_angle(wo, wi) == 0.0f);
        CHECK(is_black(bsdf.evaluate(wo, wi)));
      }
      continue;
    }
    const ChiSquare result = chi_square_sphere(sample, pdf, -1, 1, 100000);
    CHECK(result.integral <= 1 + 1e-3);
    CHECK(result.p_value > significance_of_each(tests));
  }
}

/// A sample's density and weight are those that pdf_solid_angle() and evaluate() give for its direction.
template <class Bsdf> void check_bsdf_weights(const Bsdf& bsdf) {
  double worst_pdf = 0, worst_weight = 0;
  for (const Vec3f wo : outgoing_directions())
    for (std::uint32_t i = 0; i < 1000; ++i) {
      const auto s = bsdf.sample(wo, lane_random(12, i, 0));
      if (!s.valid) continue;
      CHECK(length(s.wi) == doctest::Approx(1).epsilon(1e-5));
      const float pdf = bsdf.pdf_solid_angle(wo, s.wi);
      const auto f = bsdf.evaluate(wo, s.wi);
      worst_pdf = std::max(worst_pdf, std::fabs(double(s.pdf_solid_angle) / pdf - 1));
      for (const auto& [weight, value] : {std::pair{s.weight.c0, f.c0}, std::pair{s.weight.c1, f.c1}, std::pair{s.weight.c2, f.c2}})
        worst_weight = std::max(worst_weight, std::fabs(double(value) / pdf - weight) / std::max(double(weight), 1e-6));
    }
  CHECK(worst_pdf < 1e-4);
  CHECK(worst_weight < 1e-4);
}

/// evaluate(wo, wi) / |cos(wi)| is symmetric for reflection and, over the squared index, for transmission, where
/// `eta` is inside over outside.
template <class Bsdf> void check_bsdf_reciprocity(const Bsdf& bsdf, double eta = 1) {
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3f wo = random_direction(13, i), wi = random_direction(14, i);
    const auto scaled = [eta](const Spectrum4& f, Vec3f to) {
      const double scale = 1 / (std::fabs(double(to.z)) * (to.z < 0 ? eta * eta : 1.0));
      return std::array<double, 3>{f.c0 * scale, f.c1 * scale, f.c2 * scale};
    };
    const auto there = scaled(bsdf.evaluate(wo, wi), wi), back = scaled(bsdf.evaluate(wi, wo), wo);
    for (std::size_t c = 0; c < 3; ++c) CHECK(there[c] == doctest::Approx(back[c]).epsilon(1e-4));
  }
}

/// The mean of the samples' weights is the share of light that is scattered: at most 1 in every component. For
/// `lossless` it must be 1 wherever anything is scattered. Transmitted radiance is taken back to power by eta_scale.
template <class Bsdf> void check_white_furnace(const Bsdf& bsdf, bool lossless) {
  for (const Vec3f wo : outgoing_directions()) {
    CAPTURE(wo.z);
    if (!scatters(bsdf, wo)) continue;
    MeanVariance energy;
    for (std::uint32_t i = 0; i < 20000; ++i) {
      const auto s = bsdf.sample(wo, lane_random(15, i, 0));
      energy.add(s.valid ? double(max_component(s.weight)) * s.eta_scale : 0.0);
    }
    const double error = std::sqrt(energy.variance() / 20000);
    CHECK(energy.mean() <= 1 + 4 * error + 1e-5);
    if (lossless) CHECK(energy.mean() >= 1 - 4 * error - 1e-5);
  }
}

/// Registers of kWidth different materials give what each gives alone. make(lane) -> Bsdf<Scalar>.
template <template <class> class Bsdf, class Make> void check_bsdf_lanes(Make&& make) {
  const Bsdf<Wide> wide = wide_record<Bsdf>([&](int lane) { return make(lane); });
  double worst = 0;
  int valid = 0;
  for (std::uint32_t i = 0; i < 200 * kWidth; i += kWidth) {
    const auto wo = wide_record<Vec3>([&](int lane) { return random_direction(16, i + static_cast<std::uint32_t>(lane)); });
    const auto wi = wide_record<Vec3>([&](int lane) { return random_direction(17, i + static_cast<std::uint32_t>(lane)); });
    const auto s = wide.sample(wo, wide_random(18, i));
    const auto f = wide.evaluate(wo, wi);
    const WideFloat pdf = wide.pdf_solid_angle(wo, wi);
    for (int lane = 0; lane < kWidth; ++lane) {
      const Bsdf<Scalar> one = make(lane);
      const Vec3f o = lane_record(wo, lane), v = lane_record(wi, lane);
      worst = std::max(worst, record_difference<Spectrum>(lane_record(f, lane), one.evaluate(o, v)));
      worst = std::max(worst, difference(pdf[lane], one.pdf_solid_angle(o, v)));
      const auto expected = one.sample(o, lane_random(18, i, lane));
      CHECK(lane_of(s.valid, lane) == expected.valid);
      if (!expected.valid) continue;
      ++valid;
      worst = std::max({worst, record_difference<Vec3>(lane_record(s.wi, lane), expected.wi),
                        record_difference<Spectrum>(lane_record(s.weight, lane), expected.weight),
                        difference(s.pdf_solid_angle[lane], expected.pdf_solid_angle),
                        difference(s.eta_scale[lane], expected.eta_scale)});
    }
  }
  CHECK(valid > 10 * kWidth);
  CHECK(worst < 1e-4);
}

}  // namespace sheaf

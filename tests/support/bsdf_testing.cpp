#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

Vec3f direction_of(double cos_theta, double phi) {
  const double sin_theta = std::sqrt(std::max(0.0, 1 - cos_theta * cos_theta));
  return {static_cast<float>(sin_theta * std::cos(phi)), static_cast<float>(sin_theta * std::sin(phi)),
          static_cast<float>(cos_theta)};
}

std::vector<Vec3f> outgoing_directions() {
  std::vector<Vec3f> out;
  for (const double c : {1.0, 0.8, 0.4, 0.05, 0.001})
    for (const double side : {1.0, -1.0}) out.push_back(direction_of(side * c, 0.7 + 2.0 * c));
  return out;
}

bool scatters(const BsdfView& bsdf, Vec3f wo) {
  for (std::uint32_t i = 0; i < 64; ++i)
    if (bsdf.sample(wo, lane_random(9, i, 0)).valid) return true;
  return false;
}

void check_bsdf_sampling(const BsdfView& bsdf, int tests) {
  for (const Vec3f wo : outgoing_directions()) {
    CAPTURE(wo.z);
    const auto sample = [&](Random4<Scalar> u) -> std::optional<Vec3f> {
      const auto s = bsdf.sample(wo, u);
      return s.valid ? std::optional<Vec3f>(s.wi) : std::nullopt;
    };
    const auto pdf = [&](Vec3f wi) { return static_cast<double>(bsdf.evaluate(wo, wi).pdf_solid_angle); };
    if (!scatters(bsdf, wo)) {
      for (std::uint32_t i = 0; i < 100; ++i) {
        const Vec3f wi = random_direction(11, i);
        CHECK(bsdf.evaluate(wo, wi).pdf_solid_angle == 0.0f);
        CHECK(is_black(bsdf.evaluate(wo, wi).f_cos));
      }
      continue;
    }
    const ChiSquare result = chi_square_sphere(sample, pdf, -1, 1, 100000);
    CHECK(result.integral <= 1 + 1e-3);
    CHECK(result.p_value > significance_of_each(tests));
  }
}

void check_bsdf_sampling_with_edges(const BsdfView& bsdf, int tests, int depth) {
  constexpr int kSamples = 100000;
  constexpr double kNextToNothing = 1e-4, kQuadratureError = 2e-3;
  const CellGrid grid{0, 6.283185307179586, -1, 1};
  for (const Vec3f wo : outgoing_directions()) {
    CAPTURE(wo.z);
    std::vector<double> observed(static_cast<std::size_t>(grid.columns * grid.rows) + 1), expected;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const auto s = bsdf.sample(wo, lane_random(1, i, 0));
      const double azimuth = std::atan2(double(s.wi.y), double(s.wi.x)) + (s.wi.y < 0 ? grid.x_max : 0.0);
      const int column = std::clamp(static_cast<int>(azimuth / grid.cell_width()), 0, grid.columns - 1);
      const int row = std::clamp(static_cast<int>((s.wi.z + 1.0) / grid.cell_height()), 0, grid.rows - 1);
      observed[s.valid ? static_cast<std::size_t>(row * grid.columns + column) : observed.size() - 1] += 1;
    }
    const auto pdf = [&](double azimuth, double z) {
      return double(bsdf.evaluate(wo, direction_of(z, azimuth)).pdf_solid_angle);
    };
    const double w = grid.cell_width(), h = grid.cell_height(), sliver = h / 64;
    double integral = 0;
    for (int cell = 0; cell < grid.columns * grid.rows; ++cell) {
      const int column = cell % grid.columns, row = cell / grid.columns;
      const double x = column * w, y = -1 + row * h;
      const double split = std::fabs(y) < 1e-9 ? y + sliver : std::fabs(y + h) < 1e-9 ? y + h - sliver : y + h / 2;
      const double mass = detail::integrate(pdf, x, x + w, y, split, depth, 1e-7) +
                          detail::integrate(pdf, x, x + w, split, y + h, depth, 1e-7);
      expected.push_back(std::max(mass * kSamples, kNextToNothing));
      integral += mass;
    }
    CHECK(integral <= 1 + kQuadratureError);
    // The remainder is the difference of two numbers near 1: below the error of quadrature it tests nothing
    if (1 - integral > kQuadratureError)
      expected.push_back((1 - integral) * kSamples);
    else
      observed.pop_back();
    CHECK(chi_square(observed, expected).p_value > significance_of_each(tests));
  }
}

void check_bsdf_peak_sampling(const BsdfView& bsdf, Vec3f wo, Vec3f center, double half_width, int tests) {
  CAPTURE(wo.z);
  CAPTURE(center.z);
  const Vec3f s = normalize(cross(center, std::fabs(center.x) < 0.5f ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0}));
  const Vec3f t = cross(center, s);
  const auto sample = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const auto drawn = bsdf.sample(wo, u);
    const float height = dot(drawn.wi, center);
    if (!drawn.valid || !(height > 0.1f)) return std::nullopt;
    return std::array<double, 2>{double(dot(drawn.wi, s)) / height, double(dot(drawn.wi, t)) / height};
  };
  const auto density = [&](double x, double y) {
    const Vec3f wi = normalize(center + s * static_cast<float>(x) + t * static_cast<float>(y));
    return bsdf.evaluate(wo, wi).pdf_solid_angle / std::pow(1 + x * x + y * y, 1.5);
  };
  const ChiSquare result =
      chi_square_plane(sample, density, CellGrid{-half_width, half_width, -half_width, half_width}, 100000);
  CHECK(result.integral <= 1 + 1e-3);
  CHECK(result.integral > 0.01);
  CHECK(result.p_value > significance_of_each(tests));
}

void check_bsdf_weights(const BsdfView& bsdf, double tolerance) {
  double worst_pdf = 0, worst_weight = 0;
  for (const Vec3f wo : outgoing_directions())
    for (std::uint32_t i = 0; i < 1000; ++i) {
      const auto s = bsdf.sample(wo, lane_random(12, i, 0));
      if (!s.valid) continue;
      CHECK(length(s.wi) == near(1, 1e-5));
      const auto [f, pdf] = bsdf.evaluate(wo, s.wi);
      worst_pdf = std::max(worst_pdf, std::fabs(double(s.pdf_solid_angle) / pdf - 1));
      for (const auto& [weight, value] :
           {std::pair{s.weight.c0, f.c0}, std::pair{s.weight.c1, f.c1}, std::pair{s.weight.c2, f.c2}})
        worst_weight = std::max(worst_weight, std::fabs(double(value) / pdf - weight) / std::max(double(weight), 1e-6));
    }
  CHECK(worst_pdf < tolerance);
  CHECK(worst_weight < tolerance);
}

void check_bsdf_reciprocity(const BsdfView& bsdf, double eta) {
  // Rounding of the half vector changes values in the tails of a lobe, and refraction close to total reflection, by up
  // to all of their size. Without FMA it rounds twice as often.
  const float root = 1 + 0x1p-12f;
  const double rounding = fma(root, root, -(root * root)) != 0.0f ? 1e-6 : 2e-6;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3f wo = random_direction(13, i), wi = random_direction(14, i);
    const auto scaled = [eta](const Spectrum4& f, Vec3f to) {
      const double scale = 1 / (std::fabs(double(to.z)) * (to.z < 0 ? eta * eta : 1.0));
      return std::array<double, 3>{f.c0 * scale, f.c1 * scale, f.c2 * scale};
    };
    const auto there = scaled(bsdf.evaluate(wo, wi).f_cos, wi), back = scaled(bsdf.evaluate(wi, wo).f_cos, wo);
    for (std::size_t c = 0; c < 3; ++c) CHECK(there[c] == within(back[c], 1e-3 * std::fabs(back[c]) + rounding));
  }
}

void check_white_furnace(const BsdfView& bsdf, bool lossless) {
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

double sampled_albedo(const BsdfView& bsdf, Vec3f wo) {
  MeanVariance energy;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto s = bsdf.sample(wo, lane_random(15, i, 0));
    energy.add(s.valid ? double(max_component(s.weight)) * s.eta_scale : 0.0);
  }
  return energy.mean();
}

double largest_albedo(const BsdfView& bsdf) {
  double largest = 0;
  for (const Vec3f wo : outgoing_directions()) largest = std::max(largest, sampled_albedo(bsdf, wo));
  return largest;
}

void check_bsdf_finite(const BsdfView& bsdf) {
  const auto sound = [](float x) { return is_finite(x) && x >= 0.0f; };
  std::vector<Vec3f> directions = outgoing_directions();
  directions.push_back({1, 0, 0});
  for (const Vec3f wo : directions) {
    std::vector<Vec3f> others = directions;
    for (const Vec3f wi : {wo, -wo, Vec3f{-wo.x, -wo.y, wo.z}, Vec3f{wo.x, wo.y, -wo.z}}) others.push_back(wi);
    for (const Vec3f wi : others) {
      const auto [f, pdf] = bsdf.evaluate(wo, wi);
      CHECK((sound(f.c0) && sound(f.c1) && sound(f.c2) && sound(f.c3) && sound(pdf)));
    }
    for (const float x : {0.0f, 0.3f, 0.7f, 0.99999994f})
      for (const float y : {0.0f, 0.99999994f}) {
        const auto s = bsdf.sample(wo, {x, 0.4f, y, 0.5f});
        if (s.valid) CHECK((is_finite(s.wi) && sound(s.weight.c0) && sound(s.weight.c3) && sound(s.pdf_solid_angle)));
      }
  }
}

}  // namespace sheaf

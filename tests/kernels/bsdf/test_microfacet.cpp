// Microfacet distributions: normalization, Smith's masking functions, sampling of visible normals, and limits of the
// parameters.
#include "kernels/bsdf/microfacet.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_microfacet {

namespace {

struct Roughness {
  float u, v;
};
constexpr Roughness kRoughnesses[] = {{0.01f, 0.01f}, {0.05f, 0.01f}, {0.1f, 0.1f}, {0.3f, 1.0f}, {1.0f, 1.0f}};
constexpr float kCosines[] = {1.0f, 0.8f, 0.4f, 0.1f, 0.02f, 0.001f};
constexpr int kSamplingTests = 2 * 5 * 6;

/// A facet normal in a chart of slopes over roughness. Each is squeezed into (-1, 1) by x / (1 + |x|).
struct PlaneFacet {
  Vec3f m;
  double solid_angle_per_area;
};
PlaneFacet facet_at(double x, double y, Roughness alpha) {
  const double gx = 1 - std::fabs(x), gy = 1 - std::fabs(y), sx = x / gx * alpha.u, sy = y / gy * alpha.v;
  const double z = 1 / std::sqrt(1 + sx * sx + sy * sy);
  return {{static_cast<float>(-sx * z), static_cast<float>(-sy * z), static_cast<float>(z)},
          z * z * z * alpha.u * alpha.v / (gx * gx * gy * gy)};
}
std::array<double, 2> position_of(Vec3f m, Roughness alpha) {
  const double x = -double(m.x) / m.z / alpha.u, y = -double(m.y) / m.z / alpha.v;
  return {x / (1 + std::fabs(x)), y / (1 + std::fabs(y))};
}

/// The integral of f(m) over the upper hemisphere.
template <class F> double integrate_facets(Roughness alpha, F&& f) {
  double sum = 0;
  constexpr int kCells = 24;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      const auto integrand = [&](double x, double y) {
        const PlaneFacet facet = facet_at(x, y, alpha);
        return f(facet.m) * facet.solid_angle_per_area;
      };
      const double w = 2.0 / kCells, x = -1 + i * w, y = -1 + j * w;
      sum += detail::integrate(integrand, x, x + w, y, y + w, 4, 1e-7);
    }
  return sum;
}

template <template <class> class Distribution> void check_normalization() {
  for (const Roughness alpha : kRoughnesses) {
    CAPTURE(alpha.u);
    CAPTURE(alpha.v);
    const Distribution<Scalar> facets(alpha.u, alpha.v);
    CHECK(integrate_facets(alpha, [&](Vec3f m) { return double(facets.density(m)) * m.z; }) == near(1, 2e-4));
    for (const float cosine : {0.8f, 0.1f}) {
      // The visible facets cover the projected area (Heitz 2014, equation 14).
      const Vec3f v = direction_of(cosine, 0.4);
      const double seen = integrate_facets(alpha, [&](Vec3f m) {
        return double(facets.density(m)) * facets.smith_g1(v, m) * std::max(0.0f, dot(v, m));
      });
      CHECK(seen == near(cosine, 1e-3));
    }
  }
}

template <template <class> class Distribution> void check_visible_sampling() {
  for (const Roughness alpha : kRoughnesses)
    for (const float cosine : kCosines) {
      CAPTURE(alpha.u);
      CAPTURE(alpha.v);
      CAPTURE(cosine);
      const Distribution<Scalar> facets(alpha.u, alpha.v);
      const Vec3f wo = direction_of(cosine, 0.7 + 2 * cosine);
      // Rounding may sample facets edge-on; they reflect nothing.
      const auto sample = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
        const Vec3f m = facets.sample_visible(wo, u.y, u.z);
        if (!(facets.pdf_visible(wo, m) > 0)) return std::nullopt;
        return position_of(m, alpha);
      };
      const auto density = [&](double x, double y) {
        const PlaneFacet facet = facet_at(x, y, alpha);
        // The quadrature may miss the only visible corner of a cell, so no cell is empty.
        return facets.pdf_visible(wo, facet.m) * facet.solid_angle_per_area + 1e-8;
      };
      const ChiSquare result = chi_square_plane(sample, density, CellGrid{-1, 1, -1, 1, 15, 15}, 200000);
      CHECK(result.integral == near(1, 1e-3));
      CHECK(result.p_value > significance_of_each(kSamplingTests));
    }
}

template <template <class> class Distribution> void check_edges() {
  for (const Roughness alpha : {Roughness{1e-6f, 1e-6f}, Roughness{0.5f, 0.1f}, Roughness{1e9f, std::nanf("")}}) {
    const Distribution<Scalar> facets(alpha.u, alpha.v);
    for (const Vec3f wo : {Vec3f{0, 0, 1}, Vec3f{1, 0, 0}, Vec3f{0.6f, -0.8f, 1e-30f}, direction_of(1e-4, 2)})
      for (const float u : {0.0f, 1e-7f, 0.25f, 0.5f, 0.99999994f})
        for (const float v : {0.0f, 1e-7f, 0.5f, 0.99999994f}) {
          const Vec3f m = facets.sample_visible(wo, u, v);
          CHECK(is_finite(m));
          CHECK(m.z > 0);
          CHECK(length(m) == near(1, 1e-5));
          CHECK(is_finite(facets.density(m)));
          CHECK(is_finite(facets.pdf_visible(wo, m)));
          CHECK(is_finite(facets.smith_g1_over_cos(wo)));
        }
    CHECK(facets.density({1, 0, 0}) == 0.0f);
    CHECK(is_finite(facets.density({1, 0, 1e-10f})));
  }
  const Distribution<Scalar> facets(0.3f, 0.2f);
  const Vec3f m = normalize(Vec3f{0.5f, 0.1f, 1}), v = normalize(Vec3f{-1, 0, 0.2f});
  CHECK(dot(v, m) < 0);
  CHECK(facets.smith_g1(v, m) == 0.0f);
  CHECK(facets.smith_g1(-v, m) == 0.0f);
  CHECK(facets.smith_g1({0, 0, -1}, m) == near(facets.smith_g1({0, 0, 1}, m)));
  CHECK(facets.density(-m) == 0.0f);
}

template <template <class> class Distribution> void check_lanes() {
  double worst = 0;
  for (std::uint32_t i = 0; i < 200 * kWidth; i += kWidth) {
    const auto wo = wide_record<Vec3>([&](int lane) {
      const Vec3f d = random_direction(31, i + static_cast<std::uint32_t>(lane));
      return Vec3f{d.x, d.y, std::fabs(d.z)};
    });
    const auto alpha = [](int lane) { return 0.05f + 0.1f * static_cast<float>(lane); };
    const Distribution<Wide> wide(wide_floats(alpha), WideFloat(0.2f));
    const auto u = wide_random(32, i);
    const auto m = wide.sample_visible(wo, u.y, u.z);
    const auto pdf = wide.pdf_visible(wo, m);
    for (int lane = 0; lane < kWidth; ++lane) {
      const Distribution<Scalar> one(alpha(lane), 0.2f);
      const Vec3f o = lane_record(wo, lane), facet = lane_record(m, lane);
      worst = std::max(worst, record_difference<Vec3>(facet, one.sample_visible(o, u.y[lane], u.z[lane])));
      worst = std::max(worst, difference(pdf[lane], one.pdf_visible(o, facet)));
    }
  }
  CHECK(worst < 1e-4);
}

}  // namespace

TEST_CASE("microfacet: normal distributions integrate to the surface and visible ones to its projection") {
  check_normalization<GgxDistribution>();
  check_normalization<BeckmannDistribution>();
}

TEST_CASE("microfacet: visible normals follow their pdf from normal to grazing directions") {
  check_visible_sampling<GgxDistribution>();
  check_visible_sampling<BeckmannDistribution>();
}

TEST_CASE("microfacet: values are finite at the limits of directions and roughness") {
  check_edges<GgxDistribution>();
  check_edges<BeckmannDistribution>();
}

TEST_CASE("microfacet: SIMD results equal scalar ones") {
  check_lanes<GgxDistribution>();
  check_lanes<BeckmannDistribution>();
}

TEST_CASE("microfacet: the approximate exponential and logarithm and shadowing are close to the exact ones") {
  for (int i = 0; i <= 4000; ++i) {
    const float x = static_cast<float>(i) * 0.02f;
    CHECK(exp_minus(x) == near(std::exp(-double{x}), 2e-7 * (1 + double{x})));
    const double y = std::exp(-i * 0.004);
    CHECK(std::fabs(log2_positive(static_cast<float>(y)) - std::log2(static_cast<float>(y))) < 2e-6);
  }
  CHECK(exp_minus(kInfinity) < 1e-37f);
  for (int i = 1; i < 400; ++i) {
    const double cosine = i / 400.0, alpha = 0.6, a = cosine / (alpha * std::sqrt(1 - cosine * cosine));
    const double g1 = 2 / (1 + std::erf(a) + std::exp(-a * a) / (a * std::sqrt(3.14159265358979)));
    CHECK(BeckmannDistribution<Scalar>(0.6f, 0.6f).smith_g1(direction_of(cosine, 0.2), {0, 0, 1}) == near(g1, 3e-6));
  }
}

}  // namespace sheaf::test_microfacet

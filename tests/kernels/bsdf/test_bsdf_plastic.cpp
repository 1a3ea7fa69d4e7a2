// Plastics: a diffuse base under a smooth or rough coat, and the constants that are computed once per coat.
#include "kernels/bsdf/plastic.h"
#include "kernels/bsdf/rough_plastic.h"
#include "scene/materials/rough_coat.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_plastic {

namespace {

using Distribution = RoughnessDescription::Distribution;

PlasticBsdf<Scalar> plastic(float eta, float diffuse, float specular = 1, std::uint32_t nonlinear = 0) {
  PlasticBsdf<Scalar> bsdf;
  bsdf.eta = eta;
  bsdf.diffuse = {diffuse, 0.5f * diffuse, 0.2f * diffuse, 0};
  bsdf.specular = {specular, specular, specular, 0};
  bsdf.nonlinear = nonlinear;
  bsdf.internal_reflectance = smooth_coat_internal_reflectance(eta);
  return bsdf;
}

template <template <class> class Bsdf>
Bsdf<Scalar> rough_plastic(float eta, float alpha, float diffuse, float specular = 1, std::uint32_t nonlinear = 0) {
  constexpr auto distribution = std::is_same_v<typename Bsdf<Scalar>::Closure, RoughPlasticGgxClosure>
                                    ? Distribution::kGgx
                                    : Distribution::kBeckmann;
  const RoughCoat coat = rough_coat(distribution, alpha, eta);
  Bsdf<Scalar> bsdf;
  bsdf.eta = eta;
  bsdf.diffuse = {diffuse, 0.5f * diffuse, 0.2f * diffuse, 0};
  bsdf.specular = {specular, specular, specular, 0};
  bsdf.nonlinear = nonlinear;
  bsdf.internal_reflectance = coat.internal_reflectance;
  bsdf.alpha = alpha;
  std::copy(coat.transmittance.begin(), coat.transmittance.end(), bsdf.transmittance);
  return bsdf;
}

/// A plastic without its delta lobe: specular samples count as absorbed.
struct DiffusePart : PlasticBsdf<Scalar> {
  BsdfSample<Scalar> sample(Vec3f wo, const Random4<Scalar>& u) const {
    auto s = PlasticBsdf<Scalar>::sample(wo, u);
    s.valid = s.valid && s.pdf_solid_angle > 0;
    return s;
  }
};

constexpr int kSamplingTests = 5 * 2 + 5 * 2 * 3;

template <template <class> class Bsdf> void check_rough() {
  for (const auto& [eta, alpha] : {std::pair{1.5f, 0.15f}, std::pair{1.1f, 0.5f}, std::pair{2.4f, 1.0f}}) {
    CAPTURE_BINDING(alpha);
    const auto bsdf = rough_plastic<Bsdf>(eta, alpha, 0.7f, 0.8f, 1);
    check_bsdf_sampling_with_edges(bsdf, kSamplingTests);
    check_bsdf_weights(bsdf);
    check_bsdf_reciprocity(bsdf);
    check_bsdf_finite(bsdf);
    for (const std::uint32_t nonlinear : {0u, 1u})
      check_white_furnace(rough_plastic<Bsdf>(eta, alpha, 1, 1, nonlinear), false);
  }
  const auto bsdf = rough_plastic<Bsdf>(1.5f, 0.2f, 0.5f);
  CHECK(is_black(bsdf.evaluate({0, 0.6f, -0.8f}, {0, 0, -1}).f_cos));
  CHECK(is_black(bsdf.evaluate({0, 0.6f, 0.8f}, {0, 0, -1}).f_cos));
  CHECK_FALSE(bsdf.sample({0, 0.6f, -0.8f}, {0.5f, 0.5f, 0.5f, 0}).valid);
}

/// Transmittance of a rough interface by sampling its facets.
template <template <class> class Facets> MeanVariance transmittance_by_sampling(float cosine, float alpha, float eta) {
  const Facets<Scalar> facets(alpha, alpha);
  const Vec3f wo = direction_of(cosine, 0.3);
  MeanVariance mean;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const auto u = lane_random(51, i, 0);
    const Vec3f m = facets.sample_visible(wo, u.y, u.z);
    const auto fresnel = fresnel_dielectric<Scalar>(dot(wo, m), eta);
    const float z = m.z * (dot(wo, m) / eta + fresnel.cos_transmitted) - wo.z / eta;
    const Vec3f wi = direction_of(std::min(-z, 1.0f), 0);
    mean.add(z < 0 ? (1 - fresnel.reflectance) * facets.smith_g1(wi, {0, 0, 1}) : 0.0);
  }
  return mean;
}

double polynomial_transmittance(const RoughCoat& coat, double cosine) {
  const auto& t = coat.transmittance;
  const double y = (1 + t[0]) * cosine / (cosine + t[0]);
  double sum = 0;
  for (std::size_t i = kTransmittanceTerms - 1; i > 0; --i) sum = sum * y + t[i];
  return sum;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("plastic: the diffuse lobe follows its pdf and the coat is a mirror") {
  for (const std::uint32_t nonlinear : {0u, 1u}) {
    DiffusePart part;
    // A weak specular reflectance, so that the base is chosen often.
    static_cast<PlasticBsdf<Scalar>&>(part) = plastic(1.5f, 0.6f, 0.01f, nonlinear);
    check_bsdf_sampling(part, kSamplingTests);
    check_bsdf_weights(part);
    check_bsdf_reciprocity(part);
  }
  const auto bsdf = plastic(1.5f, 0.6f, 0.8f);
  check_bsdf_finite(bsdf);
  for (const Vec3f wo : outgoing_directions()) {
    MeanVariance mirrored;
    const double fraction = fresnel_dielectric<Scalar>(std::fabs(wo.z), 1.5f).reflectance;
    for (std::uint32_t i = 0; i < 20000; ++i) {
      const auto s = bsdf.sample(wo, lane_random(52, i, 0));
      CHECK(s.valid == (wo.z > 0));
      if (s.valid && s.pdf_solid_angle == 0) CHECK(s.wi == Vec3f{-wo.x, -wo.y, wo.z});
      mirrored.add(s.valid && s.pdf_solid_angle == 0 ? s.weight.c0 : 0.0);
    }
    if (wo.z > 0) CHECK(mirrored.p_value(0.8 * fraction) > significance_of_each(5));
  }
}

TEST_CASE("plastic: a white base under a lossless coat reflects all light") {
  for (const float eta : {1.05f, 1.5f, 2.5f})
    for (const std::uint32_t nonlinear : {0u, 1u}) check_white_furnace(plastic(eta, 1, 1, nonlinear), true);
}

TEST_CASE("plastic: values at normal incidence match computations by hand") {
  const double f = 0.04, inside = smooth_coat_internal_reflectance(1.5), through = (1 - f) * (1 - f) / (1.5 * 1.5);
  const double pi = 3.14159265358979;
  CHECK(plastic(1.5f, 0.6f).evaluate({0, 0, 1}, {0, 0, 1}).f_cos.c0 == near(0.6 / (1 - inside) * through / pi, 1e-5));
  CHECK(plastic(1.5f, 0.6f, 1, 1).evaluate({0, 0, 1}, {0, 0, 1}).f_cos.c1 ==
        near(0.3 / (1 - 0.3 * inside) * through / pi, 1e-5));
  CHECK(is_black(plastic(1.5f, 0.6f).evaluate({0, 0, -1}, {0, 0, -1}).f_cos));
  CHECK(plastic(1.5f, 0, 0).sample({0, 0, 1}, {0.3f, 0.5f, 0.5f, 0}).weight.c0 == 0.0f);
}

TEST_CASE("plastic: the internal reflectance of smooth coats matches its integral") {
  // Walsh's closed form as tabulated by Egan and Hilgeman (1973), for 1.5: 0.5963.
  CHECK(smooth_coat_internal_reflectance(1.5) == near(0.59636, 2e-4));
  CHECK(smooth_coat_internal_reflectance(1.0) == within(0, 1e-6));
  for (const double eta : {0.7, 1.2, 1.5, 2.5}) {
    double sum = 0;  // midpoint rule, from inside
    for (int i = 0; i < 20000; ++i) {
      const double c = (i + 0.5) / 20000;
      sum += 2 * c * fresnel_dielectric<Scalar>(static_cast<float>(c), static_cast<float>(1 / eta)).reflectance / 20000;
    }
    CHECK(smooth_coat_internal_reflectance(eta) == near(sum, 3e-4));
    // A nearly smooth rough coat gives the same result.
    CHECK(rough_coat(Distribution::kBeckmann, 1e-4, eta).internal_reflectance == near(sum, 2e-3));
    CHECK(rough_coat(Distribution::kGgx, 1e-4, eta).internal_reflectance == near(sum, 2e-3));
  }
}

TEST_CASE("rough plastic: the fitted transmittance matches sampled microfacets") {
  for (const float eta : {1.05f, 1.5f, 2.5f})
    for (const float alpha : {1e-4f, 0.01f, 0.1f, 0.4f, 1.0f}) {
      const RoughCoat beckmann = rough_coat(Distribution::kBeckmann, alpha, eta),
                      ggx = rough_coat(Distribution::kGgx, alpha, eta);
      CHECK(beckmann.internal_reflectance >= 0);
      CHECK(beckmann.internal_reflectance < 1);
      for (const float cosine : {1.0f, 0.7f, 0.3f, 0.1f, 0.03f, 0.01f}) {
        CAPTURE(eta);
        CAPTURE(alpha);
        CAPTURE(cosine);
        const auto b = transmittance_by_sampling<BeckmannDistribution>(cosine, alpha, eta);
        const auto g = transmittance_by_sampling<GgxDistribution>(cosine, alpha, eta);
        CHECK(std::fabs(polynomial_transmittance(beckmann, cosine) - b.mean()) <
              0.003 + 4 * std::sqrt(b.variance() / 20000));
        CHECK(std::fabs(polynomial_transmittance(ggx, cosine) - g.mean()) <
              0.003 + 4 * std::sqrt(g.variance() / 20000));
      }
    }
  for (const Distribution d : {Distribution::kBeckmann, Distribution::kGgx})
    for (const double eta : {0.5, 1.0, 4.0})
      for (const double alpha : {0.0, 0.2, 5.0})
        for (const float t : rough_coat(d, alpha, eta).transmittance) CHECK(is_finite(t));
}

TEST_CASE("rough plastic: samples have consistent weights and values are reciprocal without energy gain") {
  check_rough<RoughPlasticGgxBsdf>();
  check_rough<RoughPlasticBeckmannBsdf>();
}

TEST_CASE("rough plastic: vanishing roughness gives the smooth plastic") {
  const auto smooth = plastic(1.5f, 0.6f, 0.0f);
  const auto rough = rough_plastic<RoughPlasticBeckmannBsdf>(1.5f, 1e-4f, 0.6f, 0.0f);
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3f wo = random_direction(53, i), wi = random_direction(54, i);
    // At grazing incidence, the error of the fitted transmittance counts
    const double expected = smooth.evaluate(wo, wi).f_cos.c0, fit = 0.01 * 0.6 / 3.14159265 * std::fabs(double{wi.z});
    CHECK(rough.evaluate(wo, wi).f_cos.c0 == within(expected, 0.01 * expected + fit));
  }
}

TEST_CASE("plastics: SIMD results equal scalar ones") {
  const auto fraction = [](int lane, int k) {
    return static_cast<float>(lane + 1 + k) / static_cast<float>(kWidth + 4);
  };
  check_bsdf_lanes<PlasticBsdf>(
      [&](int l) { return plastic(1.1f + fraction(l, 0), fraction(l, 1), fraction(l, 2), l % 2 ? 1.0f : 0.0f); });
  std::array<RoughPlasticGgxBsdf<Scalar>, kWidth> ggx;
  std::array<RoughPlasticBeckmannBsdf<Scalar>, kWidth> beckmann;
  for (int l = 0; l < kWidth; ++l) {
    const auto lane = static_cast<std::size_t>(l);
    ggx[lane] = rough_plastic<RoughPlasticGgxBsdf>(1.1f + fraction(l, 0), 0.15f + fraction(l, 1), 0.8f, fraction(l, 2),
                                                   l % 2 ? 1.0f : 0.0f);
    beckmann[lane] =
        rough_plastic<RoughPlasticBeckmannBsdf>(1.1f + fraction(l, 0), 0.15f + fraction(l, 1), 0.8f, fraction(l, 2), 1);
  }
  check_bsdf_lanes<RoughPlasticGgxBsdf>([&](int l) { return ggx[static_cast<std::size_t>(l)]; });
  check_bsdf_lanes<RoughPlasticBeckmannBsdf>([&](int l) { return beckmann[static_cast<std::size_t>(l)]; });
}

TEST_SUITE_END();

TEST_CASE("plastic: interpolated coats of scenes with many roughnesses match individual ones") {
  for (const Distribution distribution : {Distribution::kBeckmann, Distribution::kGgx})
    for (const float eta : {1.5f}) {
      CAPTURE(static_cast<int>(distribution));
      CAPTURE(eta);
      RoughCoats coats;
      // Requests more than kMaxExact coats, so that the last ones are interpolated.
      for (std::size_t i = 0; i < RoughCoats::kMaxExact; ++i) coats.coat(distribution, 0.1 + 0.001 * double(i), eta);
      for (const double alpha : {1e-5, 1.3e-3, 0.0123, 0.0517, 0.2, 0.347, 0.71, 1.0, 1.9, 2e3}) {
        CAPTURE(alpha);
        const RoughCoat alone = rough_coat(distribution, alpha, eta), among = coats.coat(distribution, alpha, eta);
        CHECK(std::fabs(among.internal_reflectance - alone.internal_reflectance) < 2e-3f);
        for (int k = 0; k <= 50; ++k)
          CHECK(std::fabs(polynomial_transmittance(among, k / 50.0) - polynomial_transmittance(alone, k / 50.0)) <
                2e-3);
      }
      const RoughCoat first = rough_coat(distribution, 0.1, eta), again = coats.coat(distribution, 0.1, eta);
      CHECK(first.internal_reflectance == again.internal_reflectance);
      CHECK(first.transmittance == again.transmittance);
    }
}

}  // namespace sheaf::test_bsdf_plastic

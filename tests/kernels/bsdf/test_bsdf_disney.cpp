// The Disney BRDF: comparison with its published formulas, sampling, energy, reciprocity, and SIMD lanes.
#include "kernels/bsdf/disney.h"

#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_disney {

namespace {

using Parameters = DisneyParameters<Scalar>;

DisneyBsdf<Scalar> disney(const Parameters& p) {
  DisneyBsdf<Scalar> bsdf;
  static_cast<Parameters&>(bsdf) = p;
  return bsdf;
}

/// Members: base color, metallic, subsurface, specular, specular_tint, roughness, anisotropic, sheen, sheen_tint,
/// clearcoat, clearcoat_gloss.
const Parameters kDefault{{0.5f, 0.5f, 0.5f, 0}, 0, 0, 0.5f, 0, 0.5f, 0, 0, 0.5f, 0, 1};
const Parameters kMetal{{1, 0.8f, 0.4f, 0}, 1, 0, 0.5f, 0, 0.4f, 0.9f, 0, 0, 0, 0};
const Parameters kSkin{{0.8f, 0.5f, 0.4f, 0}, 0, 1, 1, 1, 0.7f, 0, 0.3f, 1, 0.5f, 0.2f};
const Parameters kRough{{0.9f, 0.9f, 0.9f, 0}, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0};
const Parameters kCoat{{0, 0, 0, 0}, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0};
const Parameters kEverything{{0.8f, 0.3f, 0.1f, 0}, 0.4f, 0.6f, 0.8f, 0.7f, 0.5f, 0.6f, 0.8f, 0.3f, 1, 0.1f};
const Parameters kMaterials[] = {kDefault, kMetal, kSkin, kRough, kCoat, kEverything};

constexpr int kSamplingTests = 5 * 6, kPeakTests = 2;

/// The published formulas in double precision, term by term, for one color channel `base`. `lum`: .3 R + .6 G + .1 B.
double reference(const Parameters& p, double base, double lum, Vec3f v, Vec3f l) {
  const double pi = 3.14159265358979323846;
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  const auto schlick = [](double u) { return std::pow(std::clamp(1 - u, 0.0, 1.0), 5); };
  const double x = double(v.x) + l.x, y = double(v.y) + l.y, z = double(v.z) + l.z, n = std::hypot(x, y, z);
  const double hx = x / n, hy = y / n, hz = z / n, nl = l.z, nv = v.z, lh = l.x * hx + l.y * hy + l.z * hz;
  const double tint = lum > 0 ? base / lum : 1, fl = schlick(nl), fv = schlick(nv), fh = schlick(lh);
  const double c0 = mix(p.specular * 0.08 * mix(1, tint, p.specular_tint), base, p.metallic);

  const double fd90 = 0.5 + 2 * lh * lh * p.roughness, fd = mix(1, fd90, fl) * mix(1, fd90, fv);
  const double fss90 = lh * lh * p.roughness, fss = mix(1, fss90, fl) * mix(1, fss90, fv);
  const double ss = 1.25 * (fss * (1 / (nl + nv) - 0.5) + 0.5);
  const double sheen = fh * p.sheen * mix(1, tint, p.sheen_tint);

  const double aspect = std::sqrt(1 - 0.9 * p.anisotropic), r2 = double(p.roughness) * p.roughness;
  const double ax = std::max(0.001, r2 / aspect), ay = std::max(0.001, r2 * aspect);
  const double e = std::pow(hx / ax, 2) + std::pow(hy / ay, 2) + hz * hz, ds = 1 / (pi * ax * ay * e * e);
  const auto g = [&](Vec3f w) {
    return 1 / (w.z + std::sqrt(std::pow(w.x * ax, 2) + std::pow(w.y * ay, 2) + double(w.z) * w.z));
  };
  const double a2 = std::pow(mix(0.1, 0.001, p.clearcoat_gloss), 2);
  const double dr = (a2 - 1) / (pi * std::log(a2) * (1 + (a2 - 1) * hz * hz));
  const auto gr = [](double c) { return 1 / (c + std::sqrt(0.0625 + c * c - 0.0625 * c * c)); };
  return nl * ((base / pi * mix(fd, ss, p.subsurface) + sheen) * (1 - p.metallic) + g(l) * g(v) * mix(c0, 1, fh) * ds +
               0.25 * p.clearcoat * gr(nl) * gr(nv) * mix(0.04, 1, fh) * dr);
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("disney: values equal the published formulas") {
  for (const Parameters& p : kMaterials)
    for (std::uint32_t i = 0; i < 500; ++i) {
      Vec3f wo = random_direction(31, i), wi = random_direction(32, i);
      wo.z = std::fabs(wo.z);
      wi.z = std::fabs(wi.z);
      if (i % 2 == 0) wi = normalize(Vec3f{0.05f * wi.x - wo.x, 0.05f * wi.y - wo.y, wo.z});
      const auto& c = p.base_color;
      const double lum = 0.3 * c.c0 + 0.6 * c.c1 + 0.1 * c.c2;
      const auto f = disney(p).evaluate(wo, wi).f_cos;
      for (const auto& [value, base] : {std::pair{f.c0, c.c0}, std::pair{f.c1, c.c1}, std::pair{f.c2, c.c2}}) {
        const double expected = reference(p, base, lum, wo, wi);
        // Dark values are sums of terms that cancel
        CHECK(value == within(expected, 1e-4 * (expected + 0.01)));
      }
    }
}

TEST_CASE("disney: samples follow their pdf") {
  for (const Parameters& p : kMaterials) {
    CAPTURE(&p - kMaterials);
    check_bsdf_sampling_with_edges(disney(p), kSamplingTests);
    check_bsdf_weights(disney(p));
  }
}

TEST_CASE("disney: samples of a perfectly smooth surface follow their pdf") {
  const auto smooth = disney({{0.8f, 0.8f, 0.8f, 0}, 0.5f, 0, 1, 0, 0, 0, 0, 0, 1, 1});
  check_bsdf_weights(smooth);
  check_bsdf_peak_sampling(smooth, {0.6f, 0, 0.8f}, {-0.6f, 0, 0.8f}, 0.015, kPeakTests);
  check_bsdf_peak_sampling(smooth, {0, 0, 1}, {0, 0, 1}, 0.015, kPeakTests);
}

TEST_CASE("disney: reflection is reciprocal and one-sided") {
  for (const Parameters& p : kMaterials) {
    check_bsdf_reciprocity(disney(p));
    CHECK(is_black(disney(p).evaluate({0.6f, 0, -0.8f}, {0, 0, 1}).f_cos));
    CHECK(is_black(disney(p).evaluate({0.6f, 0, 0.8f}, {0, 0.6f, -0.8f}).f_cos));
    CHECK(disney(p).evaluate({0.6f, 0, 0.8f}, {0, 0.6f, -0.8f}).pdf_solid_angle == 0.0f);
    CHECK_FALSE(scatters(disney(p), {0.6f, 0, -0.8f}));
    CHECK_FALSE(scatters(disney(p), {1, 0, 0}));
  }
}

TEST_CASE("disney: metals do not gain energy and smooth ones lose none") {
  for (const float roughness : {0.0f, 0.3f, 1.0f})
    for (const float anisotropic : {0.0f, 1.0f})
      check_white_furnace(disney({{1, 1, 1, 0}, 1, 0, 0, 0, roughness, anisotropic, 0, 0, 0, 0}), false);
  MeanVariance energy;
  const auto mirror = disney({{1, 1, 1, 0}, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  for (std::uint32_t i = 0; i < 1000; ++i) energy.add(mirror.sample({0.6f, 0, 0.8f}, lane_random(15, i, 0)).weight.c0);
  CHECK(energy.mean() == near(1, 1e-4));
}

TEST_CASE("disney: the albedo of layers on a white base exceeds 1 within bounds only") {
  for (const float roughness : {0.0f, 0.5f, 1.0f})
    for (const float subsurface : {0.0f, 1.0f}) {
      Parameters base{{1, 1, 1, 0}, 0, subsurface, 0.5f, 0, roughness, 0, 0, 0, 0, 0}, sheen = base, coat = base;
      sheen.sheen = 1;
      coat.clearcoat = 1;
      const double bare = largest_albedo(disney(base));
      CHECK(bare > 1.1);
      CHECK(bare < 1.7);
      const double by_sheen = largest_albedo(disney(sheen)) - bare, by_coat = largest_albedo(disney(coat)) - bare;
      CHECK(by_sheen > 0.07);
      CHECK(by_sheen < 0.1);
      CHECK(by_coat > 0.03);
      CHECK(by_coat < 0.06);
    }
}

TEST_CASE("disney: values are finite for all directions") {
  for (const Parameters& p : kMaterials) check_bsdf_finite(disney(p));
  check_bsdf_finite(disney({{0, 0, 0, 0}, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1}));
}

TEST_CASE("disney: SIMD results equal scalar ones") {
  const auto fraction = [](int lane, int k) { return static_cast<float>((lane * 5 + k * 3) % 8) / 7.0f; };
  check_bsdf_lanes<DisneyBsdf>([&](int lane) {
    return disney({{fraction(lane, 0), fraction(lane, 1), fraction(lane, 2), 0},
                   fraction(lane, 3),
                   fraction(lane, 4),
                   fraction(lane, 5),
                   fraction(lane, 6),
                   0.2f + 0.8f * fraction(lane, 7),
                   fraction(lane, 8),
                   fraction(lane, 9),
                   fraction(lane, 10),
                   fraction(lane, 11),
                   0.5f * fraction(lane, 12)});
  });
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_disney

// The metallic-roughness material of glTF 2.0: comparison with the formulas of the specification in double precision,
// sampling, energy, reciprocity, and the row of the material table.
#include "kernels/bsdf/metallic_roughness.h"

#include "scene/materials/row_builder.h"
#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

#include <limits>

namespace sheaf::test_bsdf_metallic_roughness {

namespace {

using Parameters = MetallicRoughnessParameters<Scalar>;

constexpr double kPiDouble = 3.14159265358979323846;

MetallicRoughnessBsdf<Scalar> bsdf_of(const Parameters& p) {
  MetallicRoughnessBsdf<Scalar> bsdf;
  static_cast<Parameters&>(bsdf) = p;
  return bsdf;
}

/// The material without extensions.
Parameters plain(float color, float metallic, float roughness) {
  Parameters p{};
  p.base_color = {color, color, color, 0};
  p.specular_color = {1, 1, 1, 0};
  p.metallic = metallic;
  p.roughness = roughness;
  p.specular = 1;
  p.f0 = 0.04f;
  return p;
}

// The sample formulas of the specification and its extensions, in double precision.

struct Vec {
  double x, y, z;
};
Vec vec_of(Vec3f v) { return {v.x, v.y, v.z}; }
double dot_of(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec half_of(Vec a, Vec b) {
  const Vec s{a.x + b.x, a.y + b.y, a.z + b.z};
  const double l = std::sqrt(dot_of(s, s));
  return {s.x / l, s.y / l, s.z / l};
}
double mix(double a, double b, double t) { return a * (1 - t) + b * t; }

/// Appendix B, specular BRDF, with the two alphas of KHR_materials_anisotropy along `t` and across.
double specular_brdf(double alpha_t, double alpha_b, double rotation, Vec v, Vec l) {
  const Vec n{0, 0, 1}, t{std::cos(rotation), std::sin(rotation), 0}, b{-std::sin(rotation), std::cos(rotation), 0};
  const Vec h = half_of(v, l);
  const double th = dot_of(t, h) / alpha_t, bh = dot_of(b, h) / alpha_b, nh = dot_of(n, h);
  const double d = 1 / (kPiDouble * alpha_t * alpha_b * std::pow(th * th + bh * bh + nh * nh, 2));
  const auto masking = [&](Vec a, Vec c) {
    return dot_of(n, a) *
           std::sqrt(std::pow(alpha_t * dot_of(t, c), 2) + std::pow(alpha_b * dot_of(b, c), 2) + c.z * c.z);
  };
  return d * 0.5 / (masking(l, v) + masking(v, l));
}

/// KHR_materials_sheen
struct ReferenceSheen {
  double alpha;

  double l(double x) const {
    const double s = (1 - alpha) * (1 - alpha);
    return mix(21.5473, 25.3245, s) / (1 + mix(3.82987, 3.32435, s) * std::pow(x, mix(0.19823, 0.16801, s))) +
           mix(-1.97760, -1.27393, s) * x + mix(-4.32054, -4.85967, s);
  }
  double lambda(double cosine) const {
    return cosine < 0.5 ? std::exp(l(cosine)) : std::exp(2 * l(0.5) - l(1 - cosine));
  }
  double brdf(Vec v, Vec l) const {
    const Vec h = half_of(v, l);
    const double d = (2 + 1 / alpha) * std::pow(std::max(1 - h.z * h.z, 0.0), 0.5 / alpha) / (2 * kPiDouble);
    return d / ((1 + lambda(v.z) + lambda(l.z)) * 4 * v.z * l.z);
  }
  /// Midpoint rule over (x, y), where the cosine is x^2 and the azimuth pi (1 - y^3): samples are dense at grazing
  /// incidence and around the forward direction.
  double albedo(double cosine, int steps) const {
    const Vec v{std::sqrt(1 - cosine * cosine), 0, cosine};
    double sum = 0;
    for (int i = 0; i < steps; ++i)
      for (int j = 0; j < steps; ++j) {
        const double x = (i + 0.5) / steps, y = (j + 0.5) / steps, z = x * x, s = std::sqrt(1 - z * z);
        const double azimuth = kPiDouble * (1 - y * y * y);
        const Vec l{s * std::cos(azimuth), s * std::sin(azimuth), z};
        sum += brdf(v, l) * z * 2 * x * 3 * kPiDouble * y * y;
      }
    return 2 * sum / (steps * steps);
  }
};

using Rgb = std::array<double, 3>;
Rgb rgb_of(const Spectrum4& s) { return {s.c0, s.c1, s.c2}; }
double max_of(const Rgb& c) { return std::max({c[0], c[1], c[2]}); }

/// f for directions on the side v.z > 0 of a surface, or across it.
Rgb reference_brdf(const Parameters& p, Vec v, Vec l_in) {
  const bool reflects = l_in.z > 0;
  const Vec l{l_in.x, l_in.y, std::fabs(l_in.z)}, h = half_of(v, l);
  const double fresnel_w = std::pow(1 - std::fabs(dot_of(v, h)), 5);
  const Rgb color = rgb_of(p.base_color), specular_color = rgb_of(p.specular_color),
            sheen_color = rgb_of(p.sheen_color);
  // Dielectric and metal
  const double alpha = std::max(double(p.roughness) * p.roughness, 1e-3);
  const double facets =
      specular_brdf(mix(alpha, 1, double(p.anisotropy) * p.anisotropy), alpha, p.anisotropy_rotation, v, l);
  Rgb fresnel, f;
  for (std::size_t c = 0; c < 3; ++c)
    fresnel[c] = p.specular * mix(std::min(p.f0 * specular_color[c], 1.0), 1, fresnel_w);
  for (std::size_t c = 0; c < 3; ++c) {
    const double below = reflects ? (1.0 - p.transmission) * color[c] / kPiDouble : p.transmission * color[c] * facets;
    const double dielectric = (1 - max_of(fresnel)) * below + (reflects ? fresnel[c] * facets : 0);
    const double metal = reflects ? mix(color[c], 1, fresnel_w) * facets : 0;
    f[c] = mix(dielectric, metal, p.metallic);
  }
  // Sheen, with the limit of SheenLobe
  if (max_of(sheen_color) > 0) {
    const ReferenceSheen sheen{std::pow(std::max(double(p.sheen_roughness), 0.1), 2)};
    const double albedo = std::max(sheen.albedo(v.z, 80), sheen.albedo(l.z, 80));
    for (std::size_t c = 0; c < 3; ++c)
      f[c] = f[c] * (1 - max_of(sheen_color) * std::min(albedo, 1.0)) +
             (reflects ? sheen_color[c] * sheen.brdf(v, l) / std::max(albedo, 1.0) : 0);
  }
  // Clearcoat, attenuated in both directions
  const double coat_alpha = std::max(double(p.clearcoat_roughness) * p.clearcoat_roughness, 1e-3);
  const auto coat = [&](double cosine) { return p.clearcoat * mix(0.04, 1, std::pow(1 - cosine, 5)); };
  for (double& each : f)
    each = each * (1 - coat(v.z)) * (1 - coat(l.z)) +
           (reflects ? coat(dot_of(v, h)) * specular_brdf(coat_alpha, coat_alpha, 0, v, l) : 0);
  return f;
}

/// A material with random parameters that uses some extensions.
struct Extensions {
  const char* name;
  bool ior, specular, transmission, anisotropy, sheen, clearcoat;
};
constexpr Extensions kExtensions[] = {
    {"none", false, false, false, false, false, false},      {"ior", true, false, false, false, false, false},
    {"specular", true, true, false, false, false, false},    {"transmission", false, false, true, false, false, false},
    {"anisotropy", false, false, false, true, false, false}, {"sheen", false, false, false, false, true, false},
    {"clearcoat", false, false, false, false, false, true},  {"all", true, true, true, true, true, true},
};

Parameters random_material(const Extensions& with, std::uint32_t i) {
  std::uint32_t k = 0;
  const auto number = [&] { return random4<Scalar>(71, i * 64 + k++, 0, 0).x; };
  const auto color = [&](float scale) { return Spectrum4(scale * number(), scale * number(), scale * number(), 0); };
  Parameters p = plain(1, i % 3 == 0 ? 0.0f : number(), 0.1f + 0.9f * number());
  p.base_color = color(1);
  if (with.ior) p.f0 = i % 4 == 0 ? 1.0f : 0.2f * number();
  if (with.specular) p.specular_color = color(3), p.specular = number();
  if (with.transmission) p.transmission = number(), p.is_thin = 1;
  if (with.anisotropy) p.anisotropy = number(), p.anisotropy_rotation = 20 * number() - 10;
  if (with.sheen) p.sheen_color = color(1), p.sheen_roughness = number();
  if (with.clearcoat) p.clearcoat = number(), p.clearcoat_roughness = 0.1f + 0.9f * number();
  return p;
}

/// Maximum difference between the code and the reference, relative to the brightest channel with or without sheen, over
/// random directions and over sampled ones, which lie in the peaks.
double reference_error(const Parameters& p, std::uint32_t seed) {
  const auto bsdf = bsdf_of(p);
  Parameters bare = p;
  bare.sheen_color = Spectrum4(0.0f);
  double worst = 0;
  for (std::uint32_t i = 0; i < 12; ++i) {
    Vec3f wo = random_direction(seed, i), wi = random_direction(seed + 1, i);
    if (p.is_thin == 0) wo.z = std::fabs(wo.z), wi.z = std::fabs(wi.z);
    if (const auto s = bsdf.sample(wo, lane_random(seed, i, 0)); i % 2 == 0 && s.valid) wi = s.wi;
    if (std::min(std::fabs(wo.z), std::fabs(wi.z)) < 0.01f) continue;
    const double side = wo.z < 0 ? -1 : 1;
    const Vec v = vec_of({wo.x, wo.y, std::fabs(wo.z)}), l{wi.x, wi.y, side * wi.z};
    const Rgb expected = reference_brdf(p, v, l), got = rgb_of(bsdf.evaluate(wo, wi).f_cos);
    const double scale = std::max({max_of(expected), max_of(reference_brdf(bare, v, l)), 1e-3});
    for (std::size_t c = 0; c < 3; ++c)
      worst = std::max(worst, std::fabs(got[c] / std::fabs(l.z) - expected[c]) / scale);
  }
  return worst;
}

Parameters with_transmission(Parameters p, float transmission) {
  p.transmission = transmission;
  p.is_thin = 1;
  return p;
}
Parameters with_anisotropy(Parameters p, float anisotropy, float rotation) {
  p.anisotropy = anisotropy;
  p.anisotropy_rotation = rotation;
  return p;
}
Parameters with_sheen(Parameters p, float color, float roughness) {
  p.sheen_color = {color, 0.5f * color, 0.25f * color, 0};
  p.sheen_roughness = roughness;
  return p;
}
Parameters with_clearcoat(Parameters p, float clearcoat, float roughness) {
  p.clearcoat = clearcoat;
  p.clearcoat_roughness = roughness;
  return p;
}

/// A dielectric that neither scatters nor reflects light: only the layers above remain.
Parameters nothing() {
  Parameters p = plain(0, 0, 1);
  p.specular = 0;
  return p;
}

const Parameters kPlastic = plain(0.7f, 0, 0.4f), kMetal = plain(0.9f, 1, 0.5f);
const Parameters kPane = with_transmission(plain(0.8f, 0.2f, 0.5f), 0.7f);
const Parameters kBrushed = with_anisotropy(plain(0.9f, 0.8f, 0.4f), 0.8f, 0.6f);
const Parameters kCloth = with_sheen(plain(0.3f, 0, 0.9f), 0.9f, 0.5f);
const Parameters kLacquer = with_clearcoat(plain(0.5f, 0.5f, 0.8f), 1, 0.4f);
const Parameters kEverything = with_clearcoat(
    with_sheen(with_anisotropy(with_transmission(plain(0.8f, 0.3f, 0.6f), 0.5f), 0.6f, 2), 0.6f, 0.3f), 0.8f, 0.5f);
const Parameters kMaterials[] = {kPlastic, kMetal, kPane, kBrushed, kCloth, kLacquer, kEverything};

constexpr int kSamplingTests = 10 * 7 + 3;

/// Mean albedo over all directions, weighted by the cosine: the fraction of light that a closed surface reflects.
double mean_albedo(const Parameters& p) {
  const auto bsdf = bsdf_of(p);
  constexpr int kSteps = 20;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)  // equal parts of the squared cosine
    sum += sampled_albedo(bsdf, direction_of(std::sqrt((i + 0.5) / kSteps), 1)) / kSteps;
  return sum;
}

MetallicRoughnessBsdf<Scalar> bsdf_of(const MetallicRoughnessDescription& description) {
  std::vector<TextureBinding> bindings;
  ClosureTables tables;
  RowContext context{bindings, tables};
  const MaterialRow row = make_row(description, context);
  CHECK(row.kind == kClosureKind<MetallicRoughnessClosure>);
  return bsdf_of_words<MetallicRoughnessBsdf<Scalar>>(nullptr, [&](int k, float& word) { word = row.words[k]; });
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("metallic-roughness: values match the formulas of glTF 2.0") {
  for (const Extensions& with : kExtensions) {
    CAPTURE(std::string(with.name));
    // The fit of the sheen's albedo has an error of 0.003.
    const double tolerance = with.sheen ? 6e-3 : 2e-4;
    double worst = 0;
    for (std::uint32_t i = 0; i < 30; ++i)
      worst = std::max(worst, reference_error(random_material(with, i), 80 + 2 * i));
    CHECK(worst < tolerance);
  }
}

TEST_CASE("metallic-roughness: samples follow their pdf") {
  for (const Parameters& p : kMaterials) {
    CAPTURE(&p - kMaterials);
    check_bsdf_sampling_with_edges(bsdf_of(p), kSamplingTests);
    check_bsdf_weights(bsdf_of(p), 5e-4);
  }
}

TEST_CASE("metallic-roughness: samples of smooth surfaces follow their pdf") {
  const Vec3f above{0.6f, 0, 0.8f};
  check_bsdf_peak_sampling(bsdf_of(plain(0.5f, 1, 0)), above, {-0.6f, 0, 0.8f}, 0.015, kSamplingTests);
  const auto pane = bsdf_of(with_transmission(plain(0.5f, 0, 0.05f), 1));
  check_bsdf_peak_sampling(pane, above, {-0.6f, 0, -0.8f}, 0.03, kSamplingTests);
  const auto lacquer = bsdf_of(with_clearcoat(kCloth, 1, 0));
  check_bsdf_peak_sampling(lacquer, above, {-0.6f, 0, 0.8f}, 0.015, kSamplingTests);
}

TEST_CASE("metallic-roughness: scattering is reciprocal") {
  for (const Parameters& p : kMaterials) {
    CAPTURE(&p - kMaterials);
    check_bsdf_reciprocity(bsdf_of(p));
  }
}

TEST_CASE("metallic-roughness: a thin wall looks the same from both sides, other surfaces are black from inside") {
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Vec3f wo = random_direction(61, i), wi = random_direction(62, i);
    const auto f = bsdf_of(kEverything).evaluate(wo, wi),
               mirrored = bsdf_of(kEverything).evaluate({wo.x, wo.y, -wo.z}, {wi.x, wi.y, -wi.z});
    CHECK(f.f_cos.c0 == mirrored.f_cos.c0);
    CHECK(f.pdf_solid_angle == mirrored.pdf_solid_angle);
    if (wo.z > 0 && wi.z > 0) continue;
    CHECK(is_black(bsdf_of(kLacquer).evaluate(wo, wi).f_cos));
    CHECK(bsdf_of(kLacquer).evaluate(wo, wi).pdf_solid_angle == 0.0f);
  }
  CHECK(scatters(bsdf_of(kEverything), {0.6f, 0, -0.8f}));
  CHECK_FALSE(scatters(bsdf_of(kLacquer), {0.6f, 0, -0.8f}));
  CHECK_FALSE(scatters(bsdf_of(nothing()), {0.6f, 0, 0.8f}));
}

TEST_CASE("metallic-roughness: metals, thin walls and layers do not gain energy") {
  for (const float roughness : {0.1f, 0.5f, 1.0f})
    for (const float anisotropy : {0.0f, 1.0f}) {
      CAPTURE(roughness);
      check_white_furnace(bsdf_of(with_anisotropy(plain(1, 1, roughness), anisotropy, 1)), false);
      check_white_furnace(bsdf_of(with_anisotropy(with_transmission(plain(1, 0, roughness), 1), anisotropy, 1)), false);
    }
  for (const Parameters& p : {plain(1, 1, 0.2f), with_transmission(plain(1, 0, 0.2f), 1), nothing()})
    for (const float roughness : {0.0f, 0.2f, 0.6f, 1.0f}) {
      CAPTURE(roughness);
      check_white_furnace(bsdf_of(with_clearcoat(p, 1, roughness)), false);
      // The fit of the sheen's albedo has an error of 0.003, and samples of sheen a variance.
      CHECK(largest_albedo(bsdf_of(with_sheen(p, 1, roughness))) < 1.02);
      CHECK(largest_albedo(bsdf_of(with_clearcoat(with_sheen(p, 1, roughness), 1, roughness))) < 1.02);
    }
  CHECK(sampled_albedo(bsdf_of(plain(1, 1, 0)), {0.6f, 0, 0.8f}) > 0.999);
  CHECK(sampled_albedo(bsdf_of(with_transmission(plain(1, 0, 0), 1)), {0.6f, 0, -0.8f}) > 0.999);
}

TEST_CASE("metallic-roughness: the albedo of white dielectrics exceeds 1 at grazing incidence only") {
  const Vec3f normal{0, 0, 1};
  const double expected[] = {1.77, 1.16, 1.02};  // numerical integration of the formulas of appendix B
  int k = 0;
  for (const float roughness : {0.1f, 0.5f, 1.0f}) {
    CAPTURE(roughness);
    const auto bsdf = bsdf_of(plain(1, 0, roughness));
    CHECK(sampled_albedo(bsdf, normal) < 1.001);
    CHECK(largest_albedo(bsdf) < expected[k++] + 0.02);
    CHECK(mean_albedo(plain(0.95f, 0, roughness)) < 1);
    // Layers do not make it brighter
    for (const float layer_roughness : {0.1f, 0.5f, 1.0f}) {
      const Parameters white = plain(1, 0, roughness);
      CHECK(largest_albedo(bsdf_of(with_clearcoat(white, 1, layer_roughness))) < expected[k - 1] + 0.02);
      CHECK(largest_albedo(bsdf_of(with_sheen(white, 1, layer_roughness))) < expected[k - 1] + 0.02);
    }
  }
  CHECK(sampled_albedo(bsdf_of(plain(1, 0, 0.1f)), direction_of(0.05, 1)) == near(1.680, 0.01));
  CHECK(sampled_albedo(bsdf_of(plain(1, 0, 0.5f)), direction_of(0.5, 1)) == near(1.011, 0.01));
}

TEST_CASE("metallic-roughness: the fitted albedo of sheen matches numerical integration") {
  double worst = 0;
  for (const double roughness : {0.1, 0.12, 0.17, 0.25, 0.33, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95, 1.0}) {
    const SheenLobe<Scalar> lobe(static_cast<float>(roughness));
    const ReferenceSheen reference{roughness * roughness};
    for (const double cosine : {0.0015, 0.01, 0.03, 0.07, 0.12, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0}) {
      const double expected = reference.albedo(cosine, 200);
      worst = std::max(worst, std::fabs(lobe.albedo(static_cast<float>(cosine)) - expected) / std::max(expected, 1.0));
    }
  }
  CHECK(worst < 0.0032);
  // The albedo of the limited lobe by sampling
  for (const float roughness : {0.5f, 0.9f}) {
    const auto cloth = bsdf_of(with_sheen(nothing(), 1, roughness));
    const double expected = ReferenceSheen{double(roughness) * roughness}.albedo(0.5, 200);
    CHECK(sampled_albedo(cloth, direction_of(0.5, 0)) == near(expected, 0.02));
  }
}

TEST_CASE("metallic-roughness: values are finite for all directions") {
  for (const Parameters& p : kMaterials) check_bsdf_finite(bsdf_of(p));
  check_bsdf_finite(bsdf_of(nothing()));
  check_bsdf_finite(bsdf_of(with_clearcoat(with_sheen(with_transmission(plain(0, 0.5f, 0), 0.5f), 1, 0), 1, 0)));
  check_bsdf_finite(bsdf_of(with_anisotropy(plain(1, 1, 0), 1, 1e6f)));
}

TEST_CASE("metallic-roughness: SIMD results equal scalar ones") {
  check_bsdf_lanes<MetallicRoughnessBsdf>(
      [](int lane) { return bsdf_of(random_material(kExtensions[lane % 8], static_cast<std::uint32_t>(lane))); });
  check_bsdf_lanes<MetallicRoughnessBsdf>([](int lane) { return bsdf_of(lane % 2 == 0 ? kPlastic : kMetal); });
}

TEST_CASE("metallic-roughness: descriptions become rows") {
  MetallicRoughnessDescription d;
  CHECK_FALSE(d.transmits());
  CHECK(bsdf_of(d).f0 == near(0.04));
  CHECK(bsdf_of(d).is_thin == 0);
  CHECK(bsdf_of(d).metallic == 1.0f);
  CHECK(bsdf_of(d).base_color.c2 == 1.0f);
  d.specular_color = SpectrumDescription::rgb(0.5f, 2, 30);
  d.sheen_color = SpectrumDescription::rgb(0.1f, 0.2f, 0.3f);
  d.roughness = 0.2f, d.specular = 0.3f, d.anisotropy = 0.4f, d.anisotropy_rotation = 5.0f, d.sheen_roughness = 0.6f;
  d.clearcoat = 0.7f, d.clearcoat_roughness = 0.8f, d.transmission = 0.9f, d.eta = 2;
  CHECK(d.transmits());
  const auto b = bsdf_of(d);
  CHECK(b.specular_color.c2 == 30.0f);
  CHECK(b.sheen_color.c1 == 0.2f);
  CHECK(b.roughness == 0.2f);
  CHECK(b.specular == 0.3f);
  CHECK(b.anisotropy == 0.4f);
  CHECK(b.anisotropy_rotation == 5.0f);
  CHECK(b.sheen_roughness == 0.6f);
  CHECK(b.clearcoat == 0.7f);
  CHECK(b.clearcoat_roughness == 0.8f);
  CHECK(b.transmission == 0.9f);
  CHECK(b.f0 == near(1.0 / 9));
  CHECK(b.is_thin == 1);
  for (const float eta : {0.0f, std::numeric_limits<float>::infinity()}) {
    d.eta = eta;
    CHECK(bsdf_of(d).f0 == 1.0f);
  }
  // A texture may make any part of the surface transparent
  d.transmission = TextureId{0};
  CHECK(d.transmits());
  CHECK(bsdf_of(d).is_thin == 1);
}

TEST_SUITE_END();

}  // namespace sheaf::test_bsdf_metallic_roughness

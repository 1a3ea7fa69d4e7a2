// The measured BRDF: tables of GGX facets against the facets themselves and against Mitsuba 3 with the same tables; and
// the conversion of spectra and colors.
#include "core/color/color.h"
#include "kernels/bsdf/list.h"
#include "scene/data/rgb_basis.h"
#include "tests/support/bsdf_testing.h"
#include "tests/support/measured_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_bsdf_measured {

namespace {

/// A BSDF with its tables.
struct Measured {
  std::vector<float> floats;
  MeasuredBsdf<Scalar> bsdf;

  explicit Measured(const MeasuredBrdf& brdf) {
    ClosureTables tables;
    bsdf.table = tables.measured(brdf);
    floats = tables.take();
    bsdf.tables = floats.data();
    bsdf.red = {1, 0, 0, 0}, bsdf.green = {0, 1, 0, 0}, bsdf.blue = {0, 0, 1, 0};
  }
};

/// Tables as fine as those of the RGL material database.
TabulatedFacets fine_facets() { return {.alpha_u = 0.4, .alpha_v = 0.4, .side = 64, .sample_side = 32}; }
TabulatedFacets fine_anisotropic_facets() {
  return {.alpha_u = 0.5, .alpha_v = 0.3, .phi = azimuths(5, 4), .side = 48, .sample_side = 32};
}

/// Compares values for incident directions in the tables with the BRDF that the tables were made from.
void check_against_facets(const TabulatedFacets& facets, const Measured& measured, float phi_o, double tolerance) {
  double worst = 0;
  for (const float theta_o : {0.0f, 0.6f, 1.2f})
    for (int i = 0; i < 40; ++i) {
      const Vec3f wo = direction_at(double(theta_o), double(phi_o));
      const Vec3f wi = direction_at(0.1 + 0.15 * (i % 8), 1.3 * i);
      const Spectrum4 f = measured.bsdf.evaluate(wo, wi).f_cos;
      const float channels[] = {f.c0, f.c1, f.c2};
      for (std::size_t c = 0; c < 3; ++c) {
        const double expected = facets.f_cos(c, wo, wi);
        worst = std::max(worst, std::fabs(double(channels[c]) - expected) / (expected + 0.02));
      }
    }
  CHECK(worst < tolerance);
}

/// f times the cosine in four channels, and the pdf, for the first pairs of random directions. Computed by Mitsuba 3.9
/// from files of the facets below.
using Reference = float[5];
constexpr Reference kIsotropic[] = {{0.00451647f, 0.00719043f, 0.00986438f, 0.0f, 0.0177186f},
                                    {0.00998406f, 0.0173819f, 0.0247798f, 0.0f, 0.0446527f},
                                    {0.0137495f, 0.023192f, 0.0326344f, 0.0f, 0.0601442f},
                                    {0.0342378f, 0.0544515f, 0.0746652f, 0.0f, 0.14245f},
                                    {0.00088979f, 0.00159194f, 0.00229408f, 0.0f, 0.00402616f},
                                    {0.00469755f, 0.0076285f, 0.0105594f, 0.0f, 0.0195752f}};
constexpr Reference kAnisotropic[] = {{0.00381381f, 0.00611005f, 0.00840628f, 0.0f, 0.0155353f},
                                      {0.0224248f, 0.0388644f, 0.0553041f, 0.0f, 0.0902016f},
                                      {0.00595922f, 0.0100999f, 0.0142406f, 0.0f, 0.0256933f},
                                      {0.043169f, 0.0688994f, 0.0946299f, 0.0f, 0.182698f},
                                      {0.00082001f, 0.00144665f, 0.00207329f, 0.0f, 0.00363514f},
                                      {0.00375038f, 0.00634748f, 0.00894458f, 0.0f, 0.0163501f}};
/// At 360, 460, 560 and 760 nm.
constexpr Reference kSpectral[] = {{0.0031795f, 0.00460181f, 0.00602413f, 0.00886876f, 0.0176972f},
                                   {0.00628513f, 0.0102202f, 0.0141552f, 0.0220252f, 0.0440489f},
                                   {0.0090283f, 0.0140509f, 0.0190734f, 0.0291186f, 0.0598799f},
                                   {0.0241309f, 0.0348829f, 0.0456349f, 0.0671389f, 0.143773f},
                                   {0.000538717f, 0.000912199f, 0.00128568f, 0.00203264f, 0.00395096f},
                                   {0.00323208f, 0.00479109f, 0.00635011f, 0.00946814f, 0.0195831f}};

template <class Bsdf, std::size_t N> void check_against_references(const Bsdf& bsdf, const Reference (&expected)[N]) {
  for (std::uint32_t i = 0; i < N; ++i) {
    Vec3f wo = random_direction(3, i), wi = random_direction(4, i);
    wo.z = std::fabs(wo.z), wi.z = std::fabs(wi.z);
    const auto [f, pdf] = bsdf.evaluate(wo, wi);
    const float found[] = {f.c0, f.c1, f.c2, f.c3, pdf};
    for (std::size_t k = 0; k < 5; ++k) CHECK(found[k] == near(expected[i][k], 2e-4));
  }
}

}  // namespace

TEST_CASE("measured: tables computed from a microfacet model scatter as the model does") {
  const Measured measured(fine_facets().tabulate());
  for (const float phi : {-2.0f, 0.0f, 0.7f}) check_against_facets(fine_facets(), measured, phi, 0.02);
}

TEST_CASE("measured: values match Mitsuba for the same tables") {
  check_against_references(Measured(TabulatedFacets{}.tabulate()).bsdf, kIsotropic);
  const TabulatedFacets half_turn{.alpha_u = 0.5, .alpha_v = 0.3, .phi = azimuths(5, 2)};
  check_against_references(Measured(half_turn.tabulate()).bsdf, kAnisotropic);
  const MeasuredBrdf spectra = TabulatedFacets{.channels = 6}.tabulate();
  ClosureTables tables;
  MeasuredSpectralBsdf<Scalar> bsdf;
  bsdf.table = tables.measured(spectra);
  const std::vector<float> floats = tables.take(), positions = wavelength_positions(spectra.wavelengths);
  bsdf.tables = floats.data();
  bsdf.position = {positions[0], positions[100], positions[200], positions[400]};
  check_against_references(bsdf, kSpectral);
}

TEST_CASE("measured: isotropic materials depend on the difference of azimuths only") {
  const Measured measured(fine_facets().tabulate());
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3f wo = random_direction(3, i), wi = random_direction(4, i);
    const float azimuth = 0.1f * static_cast<float>(i), c = std::cos(azimuth), s = std::sin(azimuth);
    const auto rotated = [&](Vec3f w) { return Vec3f{c * w.x - s * w.y, s * w.x + c * w.y, w.z}; };
    const auto f = measured.bsdf.evaluate(wo, wi), g = measured.bsdf.evaluate(rotated(wo), rotated(wi));
    CHECK(f.f_cos.c1 == near(g.f_cos.c1, 2e-3));
    CHECK(f.pdf_solid_angle == near(g.pdf_solid_angle, 2e-3));
  }
}

TEST_CASE("measured: a partial range of azimuths is extended by symmetry") {
  for (const int reduction : {1, 2, 4}) {
    CAPTURE(reduction);
    TabulatedFacets facets = fine_anisotropic_facets();
    facets.phi = azimuths(8 / reduction + 1, reduction);
    const Measured measured(facets.tabulate());
    for (int i = 0; i < 8; ++i)
      check_against_facets(facets, measured, -kPi + 0.25f * kPi * static_cast<float>(i), 0.04);
  }
}

TEST_CASE("measured: samples have consistent pdfs and weights and do not gain energy") {
  for (const TabulatedFacets& facets : {fine_facets(), fine_anisotropic_facets()}) {
    const Measured measured(facets.tabulate());
    check_bsdf_weights(measured.bsdf, 2e-3);
    check_white_furnace(measured.bsdf, false);
  }
}

TEST_CASE("measured: spectra are interpolated linearly between wavelengths") {
  const TabulatedFacets facets{.side = 16, .sample_side = 12, .channels = 5};
  const MeasuredBrdf brdf = facets.tabulate();
  const std::vector<float> positions = wavelength_positions(brdf.wavelengths);
  CHECK(positions.front() == 0);
  CHECK(positions.back() == 4);
  CHECK(positions[235] == near(2));
  CHECK(positions[300] == near(300 / 117.5));
  CHECK(wavelength_positions({400, 500, 900})[0] == 0);
  CHECK(wavelength_positions({400, 500, 600}).back() == 2);
  ClosureTables tables;
  MeasuredSpectralBsdf<Scalar> bsdf;
  bsdf.table = tables.measured(brdf);
  const std::vector<float> floats = tables.take();
  bsdf.tables = floats.data();
  bsdf.position = {0, 1, 1.25f, 4};
  const Vec3f wo = direction_at(0.6, 0), wi = direction_at(0.5, 3.0);
  const Spectrum4 f = bsdf.evaluate(wo, wi).f_cos;
  CHECK(f.c0 == near(facets.f_cos(0, wo, wi), 0.05));
  CHECK(f.c3 == near(facets.f_cos(4, wo, wi), 0.05));
  bsdf.position = {2, 3, 4, 4};
  CHECK(f.c2 == near(0.75f * f.c1 + 0.25f * bsdf.evaluate(wo, wi).f_cos.c0));
}

TEST_CASE("measured: spectra become their colors under daylight") {
  MeasuredBrdf brdf = TabulatedFacets{.theta = {0, 1}, .side = 8, .sample_side = 4, .channels = 48}.tabulate();
  const std::size_t size = 16, texel = 5;
  std::vector<float> spectrum;
  for (std::size_t c = 0; c < 48; ++c) {
    float& value = brdf.values.values[c * size + texel];
    value = 0.5f + 0.4f * std::sin(0.2f * static_cast<float>(c));
    spectrum.push_back(value);
    brdf.values.values[c * size + texel + 1] = 0.7f;
  }
  const Vec3f expected = reflectance_table_to_rgb(brdf.wavelengths, spectrum);
  make_rgb(brdf);
  CHECK(brdf.channels == 3);
  CHECK(brdf.wavelengths.empty());
  const float* values = brdf.values.values.data();
  CHECK(values[texel] == near(expected.x, 2e-3));
  CHECK(values[texel + size] == near(expected.y, 2e-3));
  CHECK(values[texel + 2 * size] == near(expected.z, 2e-3));
  for (std::size_t c = 0; c < 3; ++c) CHECK(values[texel + 1 + c * size] == near(0.7, 1e-5));
}

TEST_CASE("measured: the basis spectra for red and green and blue have these colors and add up to one") {
  std::vector<float> wavelengths, sum(471);
  for (int i = 0; i < 471; ++i) wavelengths.push_back(360.0f + static_cast<float>(i));
  for (int c = 0; c < 3; ++c) {
    const std::vector<float> basis = rgb_basis(c);
    const Vec3f rgb = reflectance_table_to_rgb(wavelengths, basis);
    CHECK(length(rgb - Vec3f{c == 0 ? 1.0f : 0.0f, c == 1 ? 1.0f : 0.0f, c == 2 ? 1.0f : 0.0f}) < 2e-3f);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      CHECK(basis[i] >= -1e-5f);
      sum[i] += basis[i];
    }
  }
  for (const float s : sum) CHECK(s == near(1, 1e-6));
}

TEST_CASE("measured: a missing table scatters nothing and does not affect other lanes") {
  const Measured measured(TabulatedFacets{}.tabulate());
  MeasuredBsdf<Scalar> bsdf = measured.bsdf;
  const Vec3f wo = direction_at(0.4, 1), wi = direction_at(0.9, 2);
  REQUIRE(bsdf.evaluate(wo, wi).pdf_solid_angle > 0);
  const float table = bsdf.table;
  for (const float wrong : {0.0f, -1.0f, 0.37f, table + 1, 1e30f, kInfinity, std::nanf("")}) {
    bsdf.table = wrong;
    CHECK(bsdf.evaluate(wo, wi).pdf_solid_angle == 0);
    CHECK_FALSE(bsdf.sample(wo, {0.1f, 0.2f, 0.3f, 0.4f}).valid);
    const auto wide = wide_record<MeasuredBsdf>([&](int lane) {
      MeasuredBsdf<Scalar> one = bsdf;
      one.table = lane == kWidth - 1 ? table : wrong;
      return one;
    });
    MeasuredBsdf<Wide> with_tables = wide;
    with_tables.tables = bsdf.tables;
    const auto value = with_tables.evaluate(broadcast<Wide>(wo), broadcast<Wide>(wi));
    bsdf.table = table;
    CHECK(value.pdf_solid_angle[kWidth - 1] == near(bsdf.evaluate(wo, wi).pdf_solid_angle, 1e-4));
  }
}

}  // namespace sheaf::test_bsdf_measured

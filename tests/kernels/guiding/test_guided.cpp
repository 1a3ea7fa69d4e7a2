// Vertices that sample both the guide and their BSDF: the one-sample MIS mixture against pdfs and weights calculated by
// hand, and against BSDF sampling alone.
#include "kernels/stages/guided.h"

#include "scene/compile/compile.h"
#include "scene/materials/rough_coat.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace sheaf::test_guided {

namespace {

constexpr double kPiD = std::numbers::pi;
/// All comparisons of means in this file together fail with probability kSignificance if guiding is correct.
const double kLevel = significance_of_each(5 * 2 * 5);

struct Lobe {
  double fraction;
  Vec3f middle;
  float kappa;
};
const std::array<Lobe, 2> kLobes{
    {{0.7, normalize(Vec3f{0.5f, 0.2f, 0.8f}), 9}, {0.3, normalize(Vec3f{-0.9f, 0.3f, -0.2f}), 2}}};

GuideMixture mixture_of(float bsdf_probability) {
  GuideMixture mixture;
  double below = 0;
  for (std::size_t k = 0; k < kGuideLobes; ++k) {
    const bool used = k < kLobes.size();
    const Lobe lobe = used ? kLobes[k] : Lobe{0, {0, 0, 1}, 1};
    mixture.x[k] = lobe.middle.x, mixture.y[k] = lobe.middle.y, mixture.z[k] = lobe.middle.z;
    mixture.kappa[k] = lobe.kappa;
    mixture.peak[k] = static_cast<float>(lobe.fraction) * lobe_peak(lobe.kappa);
    below += lobe.fraction;
    mixture.below[k] = k + 1 < kLobes.size() ? static_cast<float>(below) : 1.0f;
  }
  mixture.bsdf_probability = bsdf_probability;
  return mixture;
}

/// The guide's pdf per steradian (Fisher 1953).
double guide_pdf(Vec3f direction) {
  double sum = 0;
  for (const Lobe& lobe : kLobes) {
    const double kappa = double{lobe.kappa};
    sum += lobe.fraction * kappa / (2 * kPiD * (1 - std::exp(-2 * kappa))) *
           std::exp(kappa * (double{dot(direction, lobe.middle)} - 1));
  }
  return sum;
}

/// Means over sampled directions: of the weights with a pdf, plain and times each coordinate of the direction; and of
/// the weights of delta lobes.
struct Means {
  std::array<MeanVariance, 4> smooth;
  MeanVariance delta;

  void add(const BsdfSample<Scalar>& s) {
    const bool is_delta = s.pdf_solid_angle == 0.0f;
    const double weight = s.valid ? double{s.weight.c0} : 0;
    const double factors[] = {1, double{s.wi.x}, double{s.wi.y}, double{s.wi.z}};
    for (std::size_t k = 0; k < smooth.size(); ++k) smooth[k].add(is_delta || weight == 0 ? 0 : weight * factors[k]);
    delta.add(is_delta ? weight : 0);
  }
};

void check_same(const MeanVariance& a, const MeanVariance& b, int samples) {
  const double error = std::sqrt((a.variance() + b.variance()) / samples);
  INFO("means " << a.mean() << " and " << b.mean() << ", standard error of the difference " << error);
  if (error < 1e-9)
    CHECK(a.mean() == near(b.mean(), 1e-5));
  else
    CHECK(student_t_p_value((a.mean() - b.mean()) / error, 2 * samples - 2) >= kLevel);
}

template <template <class> class Bsdf> void check_mixture(const Bsdf<Scalar>& bsdf, bool has_delta) {
  constexpr int kSamples = 60000;
  const auto scene = compile_scene(empty_scene(1, 1));
  VertexItem<Scalar> item{};
  item.ng = item.ns = normalize(Vec3f{0.3f, -0.2f, 1});
  item.wo = normalize(Vec3f{0.6f, 0.3f, 0.7f});
  item.tangent = {1, 0};
  for (const float fraction : {0.25f, 0.8f}) {
    CAPTURE(fraction);
    const GuideMixture mixture = mixture_of(fraction);
    TestWave test(1);
    StageContext context = test.context(*scene);
    context.sample_from({.mixtures = &mixture});
    test.wave.guide_cells.store<Scalar>(0, {0u, 4u});
    Means guided, alone;
    int deltas = 0;
    double pdf_error = 0, weight_error = 0, fraction_error = 0;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
      const GuidedSample<Scalar> g = sample_guided<Scalar>(context, test.wave, 0, 1, bsdf, item, lane_random(1, i, 0));
      guided.add(g.bsdf);
      alone.add(bsdf.sample(item.wo, lane_random(2, i, 0)));
      if (!g.bsdf.valid) continue;
      if (g.bsdf.pdf_solid_angle == 0.0f) {
        ++deltas;
        CHECK(g.bsdf_pdf == 0.0f);
        CHECK(g.guided_pdf_ratio == fraction);
        continue;
      }
      const BsdfValue<Scalar> value = bsdf.evaluate(item.wo, g.bsdf.wi);
      const double a = double{fraction};
      const double pdf = a * double{value.pdf_solid_angle} + (1 - a) * guide_pdf(g.direction);
      const double weight = double{value.f_cos.c0} / pdf;
      // MIS with light sampling uses the pdf of the BSDF.
      const double bsdf_pdf = std::max(double{value.pdf_solid_angle}, 1e-10);
      pdf_error = std::max(pdf_error, std::fabs(double{g.bsdf.pdf_solid_angle} / bsdf_pdf - 1));
      weight_error = std::max(weight_error, std::fabs(double{g.bsdf.weight.c0} - weight));
      fraction_error = std::max(fraction_error, std::fabs(double{g.guide.bsdf_probability} - a));
    }
    CHECK((deltas > 1000) == has_delta);
    CHECK(pdf_error < 2e-3);
    CHECK(weight_error < 2e-3);
    CHECK(fraction_error == 0);
    for (std::size_t k = 0; k < guided.smooth.size(); ++k) {
      CAPTURE(k);
      check_same(guided.smooth[k], alone.smooth[k], kSamples);
    }
    check_same(guided.delta, alone.delta, kSamples);
  }
}

}  // namespace

TEST_CASE("guided vertices: the weights combine BSDF and guide and keep the mean of every lobe") {
  DiffuseBsdf<Scalar> diffuse;
  diffuse.reflectance = Spectrum4(0.8f);
  check_mixture<DiffuseBsdf>(diffuse, false);

  // A specular coat over a diffuse base.
  PlasticBsdf<Scalar> plastic;
  plastic.eta = 1.9f;
  plastic.diffuse = plastic.specular = Spectrum4(0.8f);
  plastic.nonlinear = 0;
  plastic.internal_reflectance = smooth_coat_internal_reflectance(1.9);
  check_mixture<PlasticBsdf>(plastic, true);

  const RoughCoat coat = rough_coat(RoughnessDescription::Distribution::kGgx, 0.2, 1.9);
  RoughPlasticGgxBsdf<Scalar> rough_plastic;
  rough_plastic.eta = 1.9f;
  rough_plastic.diffuse = rough_plastic.specular = Spectrum4(0.8f);
  rough_plastic.nonlinear = 0;
  rough_plastic.internal_reflectance = coat.internal_reflectance;
  rough_plastic.alpha = 0.2f;
  std::copy(coat.transmittance.begin(), coat.transmittance.end(), rough_plastic.transmittance);
  check_mixture<RoughPlasticGgxBsdf>(rough_plastic, false);

  RoughDielectricGgxBsdf<Scalar> glass;
  glass.eta = 1.5f;
  glass.reflectance = glass.transmittance = Spectrum4(1.0f);
  glass.alpha_u = glass.alpha_v = 0.4f;
  check_mixture<RoughDielectricGgxBsdf>(glass, false);

  RoughConductorGgxBsdf<Scalar> metal;
  metal.eta = Spectrum4(0.2f);
  metal.k = Spectrum4(3.5f);
  metal.reflectance = Spectrum4(1.0f);
  metal.alpha_u = 0.15f, metal.alpha_v = 0.4f;
  check_mixture<RoughConductorGgxBsdf>(metal, false);
}

TEST_CASE("guided vertices: dispersive parts of blends keep their own pdf and the others are guided") {
  // Mixture weights: 0.5 diffuse, 0.2 mirror, 0.3 dispersive rough glass.
  constexpr double kDiffusePdf = 0.21, kGlassPdf = 1.3, kGuidePdf = 2.2, kBsdfProbability = 0.3;
  const BlendValue<Scalar> blend{Spectrum4(0.4f), static_cast<float>(0.5 * kDiffusePdf + 0.3 * kGlassPdf),
                                 Spectrum4(0.1f), static_cast<float>(0.5 * kDiffusePdf), 0.5f};
  const GuideValue<Scalar> guide{static_cast<float>(kBsdfProbability), static_cast<float>(kGuidePdf)};
  // The diffuse part is guided, the dispersive glass is not.
  const double mixed = 0.5 * (kBsdfProbability * kDiffusePdf + (1 - kBsdfProbability) * kGuidePdf);
  CHECK(double{guided_pdf<Scalar>(guide, blend)} == near(mixed));
  const GuideValue<Scalar> none{1, 0};
  CHECK(guided_pdf<Scalar>(none, blend) == near(blend.mixed_pdf));
}

TEST_CASE("guided vertices: roulette starts below half the first expectation of a path") {
  Description d = empty_scene(1, 1);
  d.integrator.rr_depth = 3;
  const auto scene = compile_scene(d);
  const std::array<GuideMixture, 2> mixtures{mixture_of(0.5f), mixture_of(0.5f)};
  const std::array<float, 2> means{2, -1};  // the second is unknown
  TestWave test(1);
  StageContext context = test.context(*scene);
  context.sample_from({.mixtures = mixtures.data(), .means = means.data()});
  const Slot slot = 0;
  const auto survival = [&](std::uint32_t row, std::uint32_t depth, float throughput) {
    test.wave.guide_cells.store<Scalar>(0, {row, 4u});
    return expected_survival<Scalar>(context, test.wave, &slot, 0, 1, depth, throughput, 0.7f);
  };
  test.wave.guide_references[0] = 0;
  CHECK(survival(1, 1, 5) == 0.7f);
  // The first known cell gives the path its reference, 3 x 2.
  CHECK(survival(0, 1, 3) == 1);
  CHECK(survival(0, 1, 1.5f) == 1);
  CHECK(survival(0, 1, 1.2f) == near(0.8f));
  CHECK(survival(0, 4, 1.2f) == near(0.8f));
  CHECK(survival(0, 4, 3) == kLargestSurvival);
  CHECK(survival(0, 1, 0.01f) == near(1.0f / 3));
  CHECK(survival(1, 2, 0.01f) == 0.7f);
}

TEST_CASE("guide: recorded radiance is divided by the throughput over the pdf of the path") {
  Description d = mixed_scene();
  fill(d, add_sphere(d, {0, 0, -9}, 1), add_medium(d, fog(1, 0.5f)));
  const auto scene = compile_scene(d);
  TestWave test(4, 0);
  StageContext context = test.context(*scene);
  TrainingSamples log;
  log.begin(4);
  context.record_in(log);
  const std::array<Spectrum4, 2> densities = {Spectrum4(1.0f), Spectrum4{1, 2, 6, 0}};  // means 1 and 3
  for (const Spectrum4& r_u : densities) {
    const Slot slot = test.add({0, 0, 0}, {0, 0, 1});
    test.wave.rescaled_pdfs.row(slot) = {r_u, r_u};
    PathState<Scalar> path = test.wave.paths.get(slot);
    path.beta = {0.5f, 0.25f, 0.25f, 0};
    test.wave.guide_cells.store<Scalar>(0, {});
    VertexItem<Scalar> item{};
    note_directions<Scalar>(context, test.wave, &slot, 0, 1u, item, path, {0, 0, 1}, 0.5f);
    log.finish(test.wave.radiance.row(slot).task_sample, 4);
  }
  GuideView guide;
  const std::vector<GuideRecord> records = log.records(guide, {});
  REQUIRE(records.size() == 2);
  CHECK(records[0].found == near(4));
  CHECK(records[1].found == near(3 * 4));
}

}  // namespace sheaf::test_guided

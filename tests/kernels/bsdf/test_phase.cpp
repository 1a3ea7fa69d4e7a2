// Phase functions: sampling against pdfs over the whole sphere, their integrals and their mean cosines.
#include "kernels/bsdf/list.h"
#include "kernels/media/phase_value.h"
#include "scene/compile/compile_materials.h"

#include "scene/materials/closure_tables.h"
#include "tests/support/bsdf_testing.h"
#include "tests/support/near.h"

namespace sheaf::test_phase {

namespace {

constexpr float kMeanCosines[] = {-0.99f, -0.8f, -0.3f, 0.0f, 1e-4f, 0.3f, 0.8f, 0.99f};
constexpr int kTests = 2 * static_cast<int>(std::size(kMeanCosines)) + 7;  // tests that share the significance level
constexpr Vec3f kWo{0, 0, 1};

HenyeyGreensteinBsdf<Scalar> henyey_greenstein(float g) {
  HenyeyGreensteinBsdf<Scalar> phase;
  phase.g = g;
  return phase;
}

RayleighBsdf<Scalar> rayleigh() { return {}; }

/// A phase function with its table.
struct Table {
  std::vector<float> floats;
  TabulatedPhaseBsdf<Scalar> phase;

  explicit Table(const std::vector<float>& values) {
    ClosureTables tables;
    phase.table = tables.phase(values);
    floats = tables.take();
    phase.tables = floats.data();
  }
};

/// Tests samples against the pdf. The grid is azimuth by the logarithm of 1 - |cosine| on the side of `pole` (-1 or 1),
/// which resolves peaks of any width, and azimuth by z on the other side.
template <class Phase> void check_phase_sampling(const Phase& phase, double pole) {
  constexpr double kAzimuth = 6.283185307179586, kLowest = -24;  // e^-24 is below the resolution of floats
  const auto azimuth_of = [](Vec3f w) { return std::atan2(double(w.y), double(w.x)) + (w.y < 0 ? kAzimuth : 0.0); };
  const auto sample = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const Vec3f w = phase.sample(kWo, u).wi;
    const double t = pole * w.z, sine = std::hypot(double(w.x), double(w.y));
    if (!(t > 0)) return std::array<double, 2>{azimuth_of(w), -t};
    return std::array<double, 2>{azimuth_of(w), std::max(std::log(sine * sine / (1 + t)), kLowest)};
  };
  // Rows below 0 are logarithms, the others are cosines on the far side.
  const auto density = [&](double azimuth, double y) {
    const double m = y < 0 ? std::exp(y) : 1 + y, sine = std::sqrt(m * (2 - m));
    const Vec3f w{static_cast<float>(sine * std::cos(azimuth)), static_cast<float>(sine * std::sin(azimuth)),
                  static_cast<float>(pole * (1 - m))};
    return double(phase.evaluate(kWo, w).pdf_solid_angle) * (y < 0 ? m : 1.0);
  };
  const CellGrid grid{0, kAzimuth, kLowest, 1, 12, 25};
  const ChiSquare result = chi_square_plane(sample, density, grid, 100000);
  CHECK(result.integral == near(1, 1e-3));
  CHECK(result.p_value > significance_of_each(kTests));
}

/// Samples have the pdf that evaluate() returns for their direction, and weight 1.
template <class Phase> void check_phase_weights(const Phase& phase) {
  double worst = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto s = phase.sample(kWo, lane_random(12, i, 0));
    REQUIRE(s.valid);
    CHECK(length(s.wi) == near(1, 1e-6));
    CHECK((s.weight.c0 == 1.0f && s.weight.c1 == 1.0f && s.weight.c2 == 1.0f && s.weight.c3 == 1.0f));
    CHECK(s.eta_scale == 1.0f);
    const auto [f, pdf] = phase.evaluate(kWo, s.wi);
    CHECK((f.c0 == pdf && f.c1 == pdf && f.c2 == pdf && f.c3 == pdf));
    worst = std::max(worst, std::fabs(double(s.pdf_solid_angle) / pdf - 1));
  }
  CHECK(worst < 2e-5);
}

/// The mean cosine of the scattering angle.
template <class Phase> MeanVariance mean_cosine(const Phase& phase) {
  MeanVariance cosine;
  for (std::uint32_t i = 0; i < 100000; ++i) cosine.add(-double(phase.sample(kWo, lane_random(19, i, 0)).wi.z));
  return cosine;
}

/// The integral of f(c) c^power over the sphere, where c is the cosine of the scattering angle. Uses Simpson's rule in
/// log(1 - c) on the side of the peak and in c on the other side.
template <class Phase> double integral_over_sphere(const Phase& phase, double pole, double power) {
  constexpr int kSteps = 4000;
  constexpr double kLow = -30, kHigh = 0.6931471805599453;  // log(2)
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double m = std::exp(kLow + (kHigh - kLow) * i / kSteps), z = pole * (1 - m);
    const Vec3f w{static_cast<float>(std::sqrt(std::max(m * (2 - m), 0.0))), 0, static_cast<float>(z)};
    const double weight = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
    sum += weight * m * std::pow(-z, power) * phase.evaluate(kWo, w).pdf_solid_angle;
  }
  return sum * (kHigh - kLow) / kSteps / 3 * 6.283185307179586;
}

double pole_of(float g) { return g < 0 ? 1 : -1; }

}  // namespace

TEST_CASE("phase: samples follow their pdf on the whole sphere") {
  for (const float g : kMeanCosines) {
    CAPTURE(g);
    check_phase_sampling(henyey_greenstein(g), pole_of(g));
    check_phase_weights(henyey_greenstein(g));
  }
  check_phase_sampling(rayleigh(), -1);
  check_phase_weights(rayleigh());
}

TEST_CASE("phase: values integrate to one and their first moment is the mean cosine") {
  for (const float g : kMeanCosines) {
    CAPTURE(g);
    CHECK(integral_over_sphere(henyey_greenstein(g), pole_of(g), 0) == near(1, 1e-5));
    CHECK(integral_over_sphere(henyey_greenstein(g), pole_of(g), 1) == within(g, 1e-5));
  }
  CHECK(integral_over_sphere(rayleigh(), -1, 0) == near(1, 1e-5));
  CHECK(integral_over_sphere(rayleigh(), -1, 1) == within(0, 1e-5));
  CHECK(integral_over_sphere(rayleigh(), -1, 2) == near(0.4, 1e-5));
}

TEST_CASE("phase: the mean cosine of samples is g and positive for forward scattering") {
  for (const float g : kMeanCosines) {
    CAPTURE(g);
    CHECK(mean_cosine(henyey_greenstein(g)).p_value(g) > significance_of_each(kTests));
  }
  CHECK(mean_cosine(rayleigh()).p_value(0) > significance_of_each(kTests));
}

TEST_CASE("phase: values match the closed forms") {
  const double isotropic = 1 / (4 * 3.14159265358979);
  CHECK(henyey_greenstein(0).evaluate(kWo, {0.6f, 0, 0.8f}).pdf_solid_angle == near(isotropic));
  CHECK(henyey_greenstein(1e-7f).evaluate(kWo, {0.6f, 0, -0.8f}).pdf_solid_angle == near(isotropic));
  // Forward and backward: (1 + g) / (1 - g)^2 and (1 - g) / (1 + g)^2.
  CHECK(henyey_greenstein(0.5f).evaluate(kWo, {0, 0, -1}).pdf_solid_angle == near(6 * isotropic));
  CHECK(henyey_greenstein(0.5f).evaluate(kWo, {0, 0, 1}).pdf_solid_angle == near(isotropic * 0.5 / 2.25));
  CHECK(henyey_greenstein(-0.5f).evaluate(kWo, {0, 0, 1}).pdf_solid_angle == near(6 * isotropic));
  CHECK(rayleigh().evaluate(kWo, {0, 0, 1}).pdf_solid_angle == near(1.5 * isotropic));
  CHECK(rayleigh().evaluate(kWo, {1, 0, 0}).pdf_solid_angle == near(0.75 * isotropic));
}

TEST_CASE("phase: extreme random numbers and extreme g give finite directions of unit length") {
  for (const float g : {-0.9999999f, -0.99f, 0.0f, 0.99f, 0.9999999f})
    for (const float u : {0.0f, 0.5f, 0.99999994f}) {
      CAPTURE(g);
      const auto s = henyey_greenstein(g).sample(kWo, {0, u, 0.3f, 0});
      CHECK((is_finite(s.pdf_solid_angle) && s.valid));
      CHECK(length(s.wi) == near(1, 1e-6));
      CHECK(is_finite(henyey_greenstein(g).evaluate(kWo, s.wi).pdf_solid_angle));
      CHECK(length(rayleigh().sample(kWo, {0, u, 0.3f, 0}).wi) == near(1, 1e-6));
    }
}

TEST_CASE("phase: SIMD results equal scalar ones") {
  check_bsdf_lanes<HenyeyGreensteinBsdf>([](int lane) {
    return henyey_greenstein(-0.95f + 1.9f * static_cast<float>(lane) / static_cast<float>(kWidth));
  });
  check_bsdf_lanes<RayleighBsdf>([](int) { return rayleigh(); });
}

TEST_CASE("phase: tabulated phase functions are sampled exactly") {
  for (const std::vector<float>& values : {std::vector<float>{1, 2}, {0, 1, 0}, {3, 0, 0, 0, 5}, {1, 1, 1, 1}}) {
    CAPTURE(values.size());
    const Table table(values);
    check_phase_sampling(table.phase, -1);
    check_phase_weights(table.phase);
    CHECK(integral_over_sphere(table.phase, -1, 0) == near(1, 1e-3));
    for (const float u : {0.0f, 0.5f, 0.99999994f}) {
      const auto s = table.phase.sample(kWo, {0, u, 0.3f, 0});
      CHECK(length(s.wi) == near(1, 1e-6));
      CHECK(is_finite(s.pdf_solid_angle));
    }
  }
}

TEST_CASE("phase: tables begin with backward and end with forward scattering") {
  // Computed by Mitsuba 3: tabphase with the values 0.5, 1, 4, for cosines of -1, -0.5, ... 1 with the incident
  // direction.
  constexpr double kExpected[] = {0.195883, 0.122427, 0.0489708, 0.0367281, 0.0244854};
  const Table table({0.5f, 1, 4});
  for (std::size_t i = 0; i < std::size(kExpected); ++i) {
    const float z = -1.0f + 0.5f * static_cast<float>(i);
    const Vec3f wi{std::sqrt(1 - z * z), 0, z};
    CHECK(table.phase.evaluate(kWo, wi).pdf_solid_angle == near(kExpected[i], 1e-5));
  }
}

TEST_CASE("phase: a tabulated phase function matches the function it was made from") {
  const auto expected = henyey_greenstein(0.6f);
  std::vector<float> values;
  for (int i = 0; i <= 1000; ++i) {
    const float c = -1.0f + 0.002f * static_cast<float>(i), sine = std::sqrt(std::max(1 - c * c, 0.0f));
    values.push_back(7 * expected.evaluate(kWo, {sine, 0, -c}).pdf_solid_angle);
  }
  const Table table(values);
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3f wi = random_direction(4, i);
    CHECK(table.phase.evaluate(kWo, wi).pdf_solid_angle == near(expected.evaluate(kWo, wi).pdf_solid_angle, 1e-3));
  }
  CHECK(mean_cosine(table.phase).p_value(0.6) > significance_of_each(kTests));
}

TEST_CASE("phase: mixtures of tables are the weighted sums of their parts") {
  const std::vector<PhaseDescription> phases = {
      {TabulatedPhaseDescription{{0.5f, 1, 4}}, {}},
      {TabulatedPhaseDescription{{3, 0, 1, 2}}, {}},
      {BlendPhaseDescription{0.3f, {PhaseId{0}, PhaseId{1}}}, {}},
  };
  const CompiledMaterials compiled = compile_materials({}, nullptr, phases);
  SceneView scene;
  scene.materials.rows = compiled.tables.rows.data();
  scene.materials.closure_tables = compiled.tables.closure_tables.data();
  const Table first({0.5f, 1, 4}), second({3, 0, 1, 2});
  for (std::uint32_t i = 0; i < 50; ++i) {
    const Vec3f wi = random_direction(4, i);
    const float expected =
        0.7f * first.phase.evaluate(kWo, wi).pdf_solid_angle + 0.3f * second.phase.evaluate(kWo, wi).pdf_solid_angle;
    CHECK(phase_value<Scalar>(scene, compiled.row_of_phase[2], wi) == near(expected, 1e-5));
    CHECK(phase_value<Wide>(scene, compiled.row_of_phase[2], broadcast<Wide>(wi))[1] == near(expected, 1e-5));
  }
}

TEST_CASE("phase: exactly the phase functions among the closures are marked as such") {
  int phases = 0;
  for_each_bsdf(
      [&]<template <class> class Bsdf>(ClosureKind, BsdfTag<Bsdf>) { phases += kIsPhaseFunction<Bsdf<Wide>>; });
  CHECK(phases == 4);
  CHECK(kIsPhaseFunction<HenyeyGreensteinBsdf<Scalar>>);
  CHECK(kIsPhaseFunction<RayleighBsdf<Scalar>>);
  CHECK(kIsPhaseFunction<TabulatedPhaseBsdf<Scalar>>);
  CHECK(kIsPhaseFunction<SggxBsdf<Scalar>>);
}

}  // namespace sheaf::test_phase

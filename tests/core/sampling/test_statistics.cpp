// The statistical functions of the test support, against closed forms and published tables.
#include "tests/support/chi_square.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_statistics {

TEST_CASE("gamma_q agrees with closed forms") {
  for (const double x : {1e-6, 0.1, 0.9, 1.0, 2.5, 7.0, 30.0, 200.0}) {
    CAPTURE(x);
    CHECK(gamma_q(1.0, x) == near(std::exp(-x), 1e-12));
    CHECK(gamma_q(0.5, x) == near(std::erfc(std::sqrt(x)), 1e-11));
    CHECK(gamma_q(3.0, x) == near(std::exp(-x) * (1.0 + x + 0.5 * x * x), 1e-12));
  }
  CHECK(gamma_q(4.0, 0.0) == 1.0);
}

TEST_CASE("beta_i agrees with closed forms") {
  for (const double x : {0.0, 1e-5, 0.2, 0.5, 0.77, 0.999, 1.0}) {
    CAPTURE(x);
    CHECK(beta_i(1.0, 1.0, x) == near(x, 1e-12));
    CHECK(beta_i(3.0, 1.0, x) == near(x * x * x, 1e-12));
    CHECK(beta_i(2.0, 2.0, x) == near(x * x * (3.0 - 2.0 * x), 1e-12));
    CHECK(beta_i(0.5, 0.5, x) == near(std::asin(std::sqrt(x)) / std::asin(1.0), 1e-11));
  }
}

TEST_CASE("chi-square and Student-t levels agree with printed tables") {
  CHECK(chi_square_p_value(3.841, 1) == near(0.05, 1e-3));
  CHECK(chi_square_p_value(18.307, 10) == near(0.05, 1e-3));
  CHECK(chi_square_p_value(149.449, 100) == near(0.001, 1e-3));
  CHECK(student_t_p_value(12.706, 1) == near(0.05, 1e-3));
  CHECK(student_t_p_value(2.228, 10) == near(0.05, 1e-3));
  CHECK(student_t_threshold(0.001, 30) == near(3.646, 1e-3));
  CHECK(student_t_threshold(0.01, 1e9) == near(2.5758, 1e-4));
  const double each = significance_of_each(20, 0.05);
  CHECK(1.0 - std::pow(1.0 - each, 20) == near(0.05));
}

TEST_CASE("MeanVariance and its t-test agree with direct computation") {
  MeanVariance values;
  for (const double x : {4.0, 7.0, 13.0, 16.0}) values.add(x);
  CHECK(values.mean() == near(10.0));
  CHECK(values.variance() == near(30.0));
  CHECK(values.p_value(10.0) == near(1.0));
  CHECK(values.p_value(10.0 - 3.182 * std::sqrt(7.5)) == near(0.05, 1e-3));
  MeanVariance constant;
  constant.add(2.0);
  constant.add(2.0);
  CHECK(constant.p_value(2.0) == 1.0);
  CHECK(constant.p_value(2.1) == 0.0);
}

TEST_CASE("chi_square pools small cells and rejects samples where the pdf is zero") {
  const double expected[] = {2.0, 2.0, 2.0, 100.0, 100.0}, good[] = {1.0, 3.0, 2.0, 95.0, 105.0};
  const ChiSquare fit = chi_square(good, expected);
  CHECK(fit.degrees == 2);
  CHECK(fit.statistic == near(0.5));
  const double bad[] = {1.0, 3.0, 2.0, 50.0, 150.0};
  CHECK(chi_square(bad, expected).p_value < 1e-6);
  const double impossible_expected[] = {0.0, 100.0, 100.0}, impossible[] = {1.0, 100.0, 99.0};
  CHECK(chi_square(impossible, impossible_expected).p_value == 0.0);
}

TEST_CASE("chi_square_plane rejects a wrong density and a wrong total probability") {
  const CellGrid unit{0.0, 1.0, 0.0, 1.0};
  const auto uniform = [](Random4<Scalar> u) { return std::optional(std::array<double, 2>{u.x, u.y}); };
  const auto squared = [](Random4<Scalar> u) {
    return std::optional(std::array<double, 2>{std::sqrt(double(u.x)), u.y});
  };
  const auto ramp = [](double x, double) { return 2.0 * x; };
  const auto flat = [](double, double) { return 1.0; };
  CHECK(chi_square_plane(uniform, flat, unit).p_value > kSignificance);
  CHECK(chi_square_plane(squared, ramp, unit).p_value > kSignificance);
  CHECK(chi_square_plane(uniform, ramp, unit).p_value < 1e-12);
  CHECK(chi_square_plane(
            uniform, [](double, double) { return 1.05; }, unit)
            .p_value < 1e-6);
  const auto sometimes = [](Random4<Scalar> u) {
    return u.z < 0.25f ? std::nullopt : std::optional(std::array<double, 2>{u.x, u.y});
  };
  CHECK(chi_square_plane(
            sometimes, [](double, double) { return 0.75; }, unit)
            .p_value > kSignificance);
  CHECK(chi_square_plane(sometimes, flat, unit).p_value < 1e-12);
  CHECK(chi_square_plane(squared, ramp, unit).integral == near(1.0));
}

}  // namespace sheaf::test_statistics

// Significance tests: the regularized gamma and beta functions and the distributions that follow from them.
#pragma once

#include <cmath>
#include <limits>
#include <span>

namespace sheaf {

/// Probability that a correct sampler fails one statistical test case. Seeds are fixed, so a test that passes keeps
/// passing until the tested code changes.
inline constexpr double kSignificance = 1e-3;

/// Significance level of each of `tests` independent tests that together fail with probability `significance` (Sidak
/// 1967).
inline double significance_of_each(int tests, double significance = kSignificance) {
  return -std::expm1(std::log1p(-significance) / tests);
}

namespace detail {
inline constexpr double kSeriesEpsilon = 1e-15;
inline constexpr int kMaxTerms = 20000;

/// A continued fraction b0 + a1/(b1 + a2/(b2 + ...)) by the modified Lentz method; term(i, a, b) sets a_i and b_i.
template <class Term> double continued_fraction(double b0, Term&& term) {
  constexpr double kTiny = 1e-300;
  double value = b0 == 0.0 ? kTiny : b0, c = value, d = 0.0;
  for (int i = 1; i < kMaxTerms; ++i) {
    double a = 0, b = 0;
    term(i, a, b);
    d = b + a * d;
    c = b + a / c;
    if (std::fabs(d) < kTiny) d = kTiny;
    if (std::fabs(c) < kTiny) c = kTiny;
    d = 1.0 / d;
    value *= c * d;
    if (std::fabs(c * d - 1.0) < kSeriesEpsilon) break;
  }
  return value;
}
}  // namespace detail

/// Upper regularized incomplete gamma function Q(a, x), a > 0, x >= 0. Uses the power series of P = 1 - Q for x < a +
/// 1, otherwise the continued fraction of Q (DLMF 8.11.4 and 8.9.2).
inline double gamma_q(double a, double x) {
  if (!(x > 0.0)) return 1.0;
  const double front = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a, sum = term;
    for (int n = 1; n < detail::kMaxTerms && term > sum * detail::kSeriesEpsilon; ++n) sum += term *= x / (a + n);
    return 1.0 - front * sum;
  }
  return front / detail::continued_fraction(x + 1.0 - a, [&](int i, double& ai, double& bi) {
           ai = -i * (i - a);
           bi = x + 2.0 * i + 1.0 - a;
         });
}

/// Regularized incomplete beta function I_x(a, b), a, b > 0, 0 <= x <= 1 (continued fraction of DLMF 8.17.22).
inline double beta_i(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - beta_i(b, a, 1.0 - x);
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
  return front / detail::continued_fraction(1.0, [&](int i, double& ai, double& bi) {
           const int half = i / 2;
           const double m = half;
           ai = i % 2 == 0 ? m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
                           : -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
           bi = 1.0;
         });
}

/// Probability that a chi-square variable with `degrees` degrees of freedom exceeds `statistic`.
inline double chi_square_p_value(double statistic, double degrees) { return gamma_q(0.5 * degrees, 0.5 * statistic); }

/// Probability that the absolute value of a Student-t variable with `degrees` degrees of freedom exceeds |t|.
inline double student_t_p_value(double t, double degrees) {
  return beta_i(0.5 * degrees, 0.5, degrees / (degrees + t * t));
}

/// The threshold that |t| exceeds with probability `significance` (two-sided), by bisection.
inline double student_t_threshold(double significance, double degrees) {
  double low = 0.0, high = 1.0;
  while (student_t_p_value(high, degrees) > significance && high < 1e12) high *= 2.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (student_t_p_value(middle, degrees) > significance ? low : high) = middle;
  }
  return high;
}

/// Running mean and variance of a stream of values (Welford 1962).
class MeanVariance {
 public:
  void add(double x) {
    ++count_;
    const double delta = x - mean_;
    mean_ += delta / static_cast<double>(count_);
    squares_ += delta * (x - mean_);
  }
  double mean() const { return mean_; }
  /// Unbiased variance of a value; 0 for fewer than two values.
  double variance() const { return count_ > 1 ? squares_ / static_cast<double>(count_ - 1) : 0.0; }
  /// Probability of a mean at least this far from `expected` if `expected` were the true mean (Student's t-test,
  /// two-sided). Constant values give 1 or 0.
  double p_value(double expected) const {
    const double distance = mean_ - expected, error = std::sqrt(variance() / static_cast<double>(count_));
    if (!(error > 0.0)) return distance == 0.0 ? 1.0 : 0.0;
    return student_t_p_value(distance / error, static_cast<double>(count_ - 1));
  }

 private:
  long long count_ = 0;
  double mean_ = 0, squares_ = 0;
};

}  // namespace sheaf

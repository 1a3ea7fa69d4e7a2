// Chi-square tests that compare the samples of a sampler with its own pdf.
#pragma once

#include "core/math/vec.h"
#include "core/sampling/rng.h"
#include "tests/support/statistics.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

namespace sheaf {

/// Outcome of a chi-square test.
struct ChiSquare {
  double statistic = 0;
  int degrees = 0;      ///< degrees of freedom
  double p_value = 1;   ///< probability of a statistic at least this large if the expectation were true
  double integral = 1;  ///< integral of the pdf over the domain, if one was computed
};

/// Tests observed counts against expected counts over the same cells. Cells that expect fewer than 5 are pooled,
/// smallest first. A count in a cell that expects 0 fails outright (p_value 0).
inline ChiSquare chi_square(std::span<const double> observed, std::span<const double> expected) {
  constexpr double kPoolBelow = 5.0;
  std::vector<std::size_t> order(expected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
  ChiSquare result;
  double pooled_observed = 0, pooled_expected = 0;
  int cells = 0;
  for (std::size_t n = 0; n < order.size(); ++n) {
    const std::size_t i = order[n];
    if (!(expected[i] > 0.0) && observed[i] > 0.0) return {std::numeric_limits<double>::infinity(), 0, 0.0, 1.0};
    pooled_observed += observed[i];
    pooled_expected += expected[i];
    if (pooled_expected < kPoolBelow && n + 1 < order.size()) continue;
    if (!(pooled_expected > 0.0)) continue;
    const double difference = pooled_observed - pooled_expected;
    result.statistic += difference * difference / pooled_expected;
    ++cells;
    pooled_observed = pooled_expected = 0;
  }
  result.degrees = cells - 1;
  if (result.degrees > 0) result.p_value = chi_square_p_value(result.statistic, result.degrees);
  return result;
}

/// Tests counts over cells of equal probability.
inline ChiSquare chi_square_uniform(std::span<const double> observed) {
  const double total = std::accumulate(observed.begin(), observed.end(), 0.0);
  return chi_square(observed, std::vector<double>(observed.size(), total / static_cast<double>(observed.size())));
}

/// A rectangle cut into equal cells.
struct CellGrid {
  double x_min, x_max, y_min, y_max;
  int columns = 24, rows = 16;
  double cell_width() const { return (x_max - x_min) / columns; }
  double cell_height() const { return (y_max - y_min) / rows; }
};

namespace detail {
/// Integral of f over a box by adaptive 3 x 3 Gauss quadrature; subdivides while the four quarters disagree with the
/// whole.
template <class F> double integrate(F&& f, double x0, double x1, double y0, double y1, int depth, double tolerance) {
  static constexpr double kNodes[3] = {-0.7745966692414834, 0.0, 0.7745966692414834};
  static constexpr double kWeights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  const auto gauss = [&](double ax, double bx, double ay, double by) {
    double sum = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sum += kWeights[i] * kWeights[j] *
               f(0.5 * (ax + bx) + 0.5 * (bx - ax) * kNodes[i], 0.5 * (ay + by) + 0.5 * (by - ay) * kNodes[j]);
    return sum * (bx - ax) * (by - ay);
  };
  const double xm = 0.5 * (x0 + x1), ym = 0.5 * (y0 + y1);
  const double fine = gauss(x0, xm, y0, ym) + gauss(xm, x1, y0, ym) + gauss(x0, xm, ym, y1) + gauss(xm, x1, ym, y1);
  if (depth == 0 || std::fabs(fine - gauss(x0, x1, y0, y1)) < tolerance) return fine;
  return integrate(f, x0, xm, y0, ym, depth - 1, tolerance / 4) +
         integrate(f, xm, x1, y0, ym, depth - 1, tolerance / 4) +
         integrate(f, x0, xm, ym, y1, depth - 1, tolerance / 4) +
         integrate(f, xm, x1, ym, y1, depth - 1, tolerance / 4);
}
}  // namespace detail

/// Draws `samples` points and tests their counts against the integrals of the pdf.
/// sample(Random4<Scalar>) -> std::optional<std::array<double, 2>>, empty for an invalid sample;
/// density(x, y) -> double, per unit area of the grid. If it integrates to less than 1, the rest is the probability of
/// a sample that is invalid or outside of the grid.
template <class Sample, class Density>
ChiSquare chi_square_plane(Sample&& sample, Density&& density, const CellGrid& grid, int samples = 200000,
                           std::uint32_t seed = 1) {
  const auto cells = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  std::vector<double> observed(cells + 1), expected(cells + 1);
  for (int i = 0; i < samples; ++i) {
    const std::optional<std::array<double, 2>> p = sample(random4<Scalar>(seed, static_cast<std::uint32_t>(i), 0, 0));
    std::size_t cell = cells;
    if (p && (*p)[0] >= grid.x_min && (*p)[0] <= grid.x_max && (*p)[1] >= grid.y_min && (*p)[1] <= grid.y_max) {
      const int column = std::min(static_cast<int>(((*p)[0] - grid.x_min) / grid.cell_width()), grid.columns - 1);
      const int row = std::min(static_cast<int>(((*p)[1] - grid.y_min) / grid.cell_height()), grid.rows - 1);
      cell = static_cast<std::size_t>(row * grid.columns + column);
    }
    observed[cell] += 1.0;
  }
  double integral = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const auto column = static_cast<int>(cell) % grid.columns, row = static_cast<int>(cell) / grid.columns;
    const double x = grid.x_min + column * grid.cell_width(), y = grid.y_min + row * grid.cell_height();
    const double mass = detail::integrate(density, x, x + grid.cell_width(), y, y + grid.cell_height(), 6, 1e-7);
    integral += mass;
    expected[cell] = mass * samples;
  }
  constexpr double kIntegralError = 1e-4;  // of the numerical integration
  constexpr double kNext = 1e-9;           // samples outside of the grid within that error join the pool of rare cells
  expected[cells] = (integral < 1.0 - kIntegralError ? 1.0 - integral : kNext) * samples;
  ChiSquare result = chi_square(observed, expected);
  result.integral = integral;
  return result;
}

/// The same for directions.
/// sample(Random4<Scalar>) -> std::optional<Vec3f>, unit length; pdf(Vec3f) -> per solid angle. The grid is azimuth by
/// z, so that equal areas are equal solid angles; [z_min, z_max] restricts it to the part of the sphere that contains
/// the samples.
template <class Sample, class Pdf>
ChiSquare chi_square_sphere(Sample&& sample, Pdf&& pdf, double z_min = -1.0, double z_max = 1.0, int samples = 200000,
                            std::uint32_t seed = 1) {
  constexpr double kAzimuth = 6.283185307179586476925;
  const auto to_plane = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const std::optional<Vec3f> w = sample(u);
    if (!w) return std::nullopt;
    const double azimuth = std::atan2(static_cast<double>(w->y), static_cast<double>(w->x));
    return std::array<double, 2>{azimuth < 0.0 ? azimuth + kAzimuth : azimuth, static_cast<double>(w->z)};
  };
  const auto density = [&](double azimuth, double z) -> double {
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
    return pdf(Vec3f{static_cast<float>(r * std::cos(azimuth)), static_cast<float>(r * std::sin(azimuth)),
                     static_cast<float>(z)});
  };
  return chi_square_plane(to_plane, density, CellGrid{0.0, kAzimuth, z_min, z_max}, samples, seed);
}

}  // namespace sheaf

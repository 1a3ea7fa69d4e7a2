// Quantile tables: sampling probabilities are right, every entry of positive weight is reachable, stratification is
// preserved, and rounding of the probabilities adds little variance.
#include "core/sampling/quantile_table.h"

#include "core/sampling/rng.h"
#include "core/soa/large_table.h"
#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numeric>

namespace sheaf::test_quantile_table {

namespace {

using Weights = std::vector<double>;

double uniform(std::uint32_t i) { return static_cast<double>(random4<Scalar>(5, i, 0, 0).x); }

Weights weights_of(std::uint32_t count, const std::function<double(std::uint32_t)>& f) {
  Weights w(count);
  for (std::uint32_t i = 0; i < count; ++i) w[i] = f(i);
  return w;
}

/// Equal weights, a peak, gaps, several decades, steps, more entries than quantiles, and few entries.
std::vector<Weights> all_weights() {
  return {{3},
          {1, 0},
          {0, 0, 2, 0, 5e-9},
          weights_of(3000, [](std::uint32_t) { return 2.0; }),
          weights_of(700, [](std::uint32_t i) { return i == 123 ? 1e6 : 1.0; }),
          weights_of(4000, [](std::uint32_t i) { return i % 2 == 0 ? 1 + uniform(i) : 0; }),
          weights_of(5000, [](std::uint32_t i) { return std::pow(10, 6 * uniform(i)); }),
          weights_of(2500, [](std::uint32_t i) { return i < 1200   ? 1e-3
                                                        : i < 1210 ? 500
                                                                   : 1; }),
          weights_of(60000, [](std::uint32_t i) { return i % 9000 == 8500 ? 1.0 : 0.0; })};
}

/// A table and the probabilities of its entries.
struct Table {
  std::vector<Quantile> rows = std::vector<Quantile>(kQuantiles);
  Weights probabilities;

  explicit Table(Weights weights) : probabilities(std::move(weights)) {
    REQUIRE(build_quantiles(probabilities, rows.data()));
  }
  QuantileDraw<Scalar> draw(float u) const { return draw_quantile<Scalar>(rows.data(), 0, u); }
  float remapped(const QuantileDraw<Scalar>& drawn) const {
    return drawn.remapped(static_cast<float>(probabilities[drawn.index]));
  }
};

/// Sum of w^2 / probability over the squared sum of w; 1 if the probabilities are proportional to the weights.
double second_moment(const Weights& weights, const Weights& probabilities) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  double moment = 0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (weights[i] > 0) moment += weights[i] / sum * (weights[i] / sum) / probabilities[i];
  return moment;
}

}  // namespace

TEST_CASE("quantile table: probabilities add up to one and are positive wherever weights are") {
  for (const Weights& weights : all_weights()) {
    const Table table(weights);
    double sum = 0;
    int missed = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      sum += table.probabilities[i];
      missed += weights[i] > 0 && !(table.probabilities[i] > 0);
    }
    CHECK(sum == near(1, 1e-12));
    CHECK(missed == 0);
    CHECK(table.probabilities.front() * (weights.front() == 0) == 0);
    CHECK(table.probabilities.back() * (weights.back() == 0) == 0);
  }
  Weights none(20);
  Quantile unused[kQuantiles];
  CHECK(!build_quantiles(none, unused));
}

TEST_CASE("quantile table: entries are drawn with their probability") {
  const std::vector<Weights> cases = all_weights();
  for (const Weights& weights : cases) {
    const Table table(weights);
    // All 20-bit numbers; each entry of a run receives a whole number of them.
    constexpr std::uint32_t kNumbers = 1u << 20;
    std::vector<double> found(weights.size());
    double worst = 0;
    for (std::uint32_t k = 0; k < kNumbers; ++k)
      found[table.draw((static_cast<float>(k) + 0.5f) / kNumbers).index] += 1;
    for (std::size_t i = 0; i < weights.size(); ++i)
      worst = std::max(worst, std::fabs(found[i] - table.probabilities[i] * kNumbers));
    CHECK(worst <= 1.0);
  }
}

TEST_CASE("quantile table: stratified numbers stay stratified") {
  for (const Weights& weights : all_weights()) {
    const Table table(weights);
    double last = 0;
    int wrong = 0;
    std::vector<double> cells(16);
    for (std::uint32_t k = 0; k < 1u << 16; ++k) {
      const auto drawn = table.draw(static_cast<float>(k) / 65536);
      const float remapped = table.remapped(drawn);
      wrong += drawn.index + double(remapped) < last - 1e-6 || !(remapped >= 0 && remapped < 1);
      last = drawn.index + double(remapped);
      cells[static_cast<std::size_t>(remapped * 16)] += 1;
    }
    CHECK(wrong == 0);
    CHECK(table.draw(0x1.fffffep-1f).index < weights.size());
    // Each sixteenth of the entries is chosen equally often, up to rounding.
    for (const double count : cells) CHECK(std::fabs(count - 4096) < 1100);
  }
  // The subintervals of an entry are contiguous.
  const Table one(Weights{1});
  for (std::uint32_t k = 0; k < 1000; ++k)
    CHECK(one.remapped(one.draw(static_cast<float>(k) / 1000)) == near(k / 1000.0, 1e-5));
}

TEST_CASE("quantile table: SIMD results equal scalar ones") {
  for (const Weights& weights : all_weights()) {
    const Table table(weights);
    for (std::uint32_t i = 0; i < 200; ++i) {
      const WideFloat u =
          wide_floats([&](int lane) { return random4<Scalar>(6, i, static_cast<std::uint32_t>(lane), 0).x; });
      const auto wide = draw_quantile<Wide>(table.rows.data(), WideUint(0u), u);
      for (int lane = 0; lane < kWidth; ++lane) {
        const auto single = table.draw(u[lane]);
        CHECK((wide.index[lane] == single.index && wide.position[lane] == single.position &&
               wide.quantile[lane] == single.quantile));
      }
    }
  }
}

TEST_CASE("quantile table: rounding adds little variance") {
  const std::vector<Weights> cases = all_weights();
  CHECK(second_moment(cases[3], Table(cases[3]).probabilities) < 1.02);
  CHECK(second_moment(cases[4], Table(cases[4]).probabilities) < 1.01);
  CHECK(second_moment(cases[7], Table(cases[7]).probabilities) < 1.01);
  const Weights even = weights_of(500, [](std::uint32_t i) { return 1 + uniform(i); });
  CHECK(second_moment(even, Table(even).probabilities) < 1.04);
}

TEST_CASE("large table: a table of any size begins at a cache line and keeps its contents") {
  LargeTable<std::uint32_t> table;
  for (std::uint32_t i = 0; i < 3000000; ++i) table.push_back(i * 2654435761u);
  const LargeTable<std::uint32_t> copy = table;
  table.resize(10);
  table.shrink_to_fit();
  CHECK(reinterpret_cast<std::uintptr_t>(copy.data()) % 64 == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(table.data()) % 64 == 0);
  int wrong = 0;
  for (std::uint32_t i = 0; i < 3000000; ++i) wrong += copy[i] != i * 2654435761u;
  CHECK(wrong == 0);
  CHECK(table[9] == copy[9]);
}

}  // namespace sheaf::test_quantile_table

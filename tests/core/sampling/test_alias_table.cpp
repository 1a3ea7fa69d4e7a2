// Alias tables: probabilities, ends of the range, and invalid weights.
#include "core/sampling/alias_table.h"

#include "core/io/error.h"
#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_alias_table {

namespace {

using Weights = std::vector<float>;

/// Positive weights over five decades, with a run of zeros and zeros at both ends.
Weights uneven_weights(std::uint32_t count) {
  Weights weights;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Random4<Scalar> u = random4<Scalar>(5, i, 0, 0);
    weights.push_back(u.x < 0.2f ? 0.0f : std::pow(10.0f, 5.0f * u.y - 3.0f));
  }
  weights.front() = weights.back() = 0.0f;
  return weights;
}

double sum_of(const Weights& weights) { return std::accumulate(weights.begin(), weights.end(), 0.0); }

/// Random numbers, including both ends of the range.
float number(std::uint32_t i) { return i == 0 ? 0.0f : i == 1 ? kOneMinusEpsilon : random4<Scalar>(2, i, 0, 0).x; }

const Weights kBadWeights[] = {
    {}, {0.0f}, {0.0f, 0.0f}, {1.0f, -1.0f}, {1.0f, kInfinity}, {1.0f, std::numeric_limits<float>::quiet_NaN()}};

AliasSample<Scalar> sample_all(const std::vector<AliasEntry>& table, float u) {
  return sample_alias<Scalar>(table.data(), 0, static_cast<std::uint32_t>(table.size()), u);
}

}  // namespace

TEST_CASE("alias table: rows add up to the normalized weights") {
  for (const std::uint32_t count : {3u, 17u, 1000u, 65536u}) {
    const Weights weights = uneven_weights(std::max(count, 4u));
    const auto table = build_alias_table(weights);
    const double sum = sum_of(weights), rows = static_cast<double>(table.size());
    std::vector<double> implied(table.size());
    int wrong = 0;
    for (std::size_t i = 0; i < table.size(); ++i) {
      implied[i] += table[i].threshold / rows;
      implied[table[i].alias] += (1.0 - table[i].threshold) / rows;
      wrong += table[i].pdf != static_cast<float>(weights[i] / sum);
      wrong += table[i].alias_pdf != static_cast<float>(weights[table[i].alias] / sum);
      wrong += !(table[i].threshold >= 0.0f && table[i].threshold <= 1.0f);
    }
    CHECK(wrong == 0);
    double worst = 0;
    for (std::size_t i = 0; i < table.size(); ++i)
      worst = std::max(worst, std::fabs(implied[i] - weights[i] / sum) * rows);
    CHECK(worst < 1e-6 * std::sqrt(rows) + 1e-6);
  }
}

TEST_CASE("alias table: samples follow the weights, and the remapped number is uniform for each") {
  const Weights weights = uneven_weights(40);
  const auto table = build_alias_table(weights);
  constexpr int kSamples = 400000;
  constexpr std::size_t kParts = 8;
  std::vector<double> observed(weights.size() * kParts), expected(observed.size());
  for (int i = 0; i < kSamples; ++i) {
    const AliasSample<Scalar> s = sample_all(table, number(static_cast<std::uint32_t>(i)));
    if (!(s.index < weights.size() && s.remapped >= 0.0f && s.remapped < 1.0f)) {
      FAIL("sample out of range");
      break;
    }
    observed[s.index * kParts + static_cast<std::size_t>(s.remapped * kParts)] += 1.0;
  }
  for (std::size_t i = 0; i < expected.size(); ++i)
    expected[i] = weights[i / kParts] / sum_of(weights) * kSamples / kParts;
  CHECK(chi_square(observed, expected).p_value > kSignificance);
}

TEST_CASE("alias table: zero weights are never drawn and the pdf is that of the entry") {
  for (const Weights& weights : {Weights{0, 1}, Weights{1, 0}, Weights{0, 0, 5, 0}, Weights{1, 0, 1e-30f, 0, 1e30f},
                                 Weights{3}, Weights{0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.0f}, uneven_weights(3000)}) {
    const auto table = build_alias_table(weights);
    int wrong = 0;
    for (std::uint32_t i = 0; i < 1u << 17; ++i) {
      const float u = i == 0 ? kOneMinusEpsilon : static_cast<float>(i - 1) * 0x1p-17f;
      const AliasSample<Scalar> s = sample_all(table, u);
      wrong += s.index >= weights.size() || !(weights[s.index] > 0.0f) || s.pdf != table[s.index].pdf ||
               !(s.remapped >= 0.0f && s.remapped < 1.0f);
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("alias table: every lane draws from its own part of a table") {
  const Weights first = uneven_weights(9), second = {1.0f}, third = uneven_weights(300);
  std::vector<AliasEntry> joined;
  std::vector<std::uint32_t> offsets, counts;
  for (const Weights& part : {first, second, third}) {
    const auto table = build_alias_table(part);
    offsets.push_back(static_cast<std::uint32_t>(joined.size()));
    counts.push_back(static_cast<std::uint32_t>(table.size()));
    joined.insert(joined.end(), table.begin(), table.end());
  }
  int wrong = 0;
  double worst = 0;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const auto part = [i](int lane) { return (i + static_cast<std::uint32_t>(lane)) % 3; };
    const auto u = [i](int lane) { return number(i + 1000u * static_cast<std::uint32_t>(lane)); };
    const AliasSample<Wide> wide =
        sample_alias<Wide>(joined.data(), wide_uints([&](int k) { return offsets[part(k)]; }),
                           wide_uints([&](int k) { return counts[part(k)]; }), wide_floats(u));
    for (int lane = 0; lane < kWidth; ++lane) {
      const AliasSample<Scalar> one =
          sample_alias<Scalar>(joined.data(), offsets[part(lane)], counts[part(lane)], u(lane));
      wrong += wide.index[lane] != one.index || wide.pdf[lane] != one.pdf || one.index >= counts[part(lane)];
      worst = std::max(worst, difference(wide.remapped[lane], one.remapped));
    }
  }
  CHECK(wrong == 0);
  CHECK(worst < 1e-6);
}

TEST_CASE("alias table: unusable weights are refused") {
  for (const Weights& bad : kBadWeights) CHECK_THROWS_AS(build_alias_table(bad), SceneError);
}

}  // namespace sheaf::test_alias_table

// Alias tables and piecewise-constant distributions: probabilities, ends of the range, and invalid weights.
#include "core/distribution.h"

#include "core/error.h"
#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_distribution {

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

TEST_CASE("alias table: the rows add up to the normalised weights") {
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

TEST_CASE("alias table: samples follow the weights and the remapped number is uniform for each entry") {
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

TEST_CASE("alias table: entries of weight zero are never drawn and each pdf is that of its entry") {
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

TEST_CASE("alias table: every lane can draw from its own range of a table") {
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

TEST_CASE("distributions: unusable weights are rejected") {
  for (const Weights& bad : kBadWeights) {
    CHECK_THROWS_AS(build_alias_table(bad), SceneError);
    CHECK_THROWS_AS(Distribution1D{bad}, SceneError);
    CHECK_THROWS_AS(Distribution2D(bad, bad.size(), 1), SceneError);
  }
  const Weights six(6, 1.0f);
  CHECK_THROWS_AS(Distribution2D(six, 2, 2), SceneError);
  CHECK_THROWS_AS(Distribution2D(six, 0, 6), SceneError);
  CHECK_THROWS_AS(Distribution2D(six, std::size_t{1} << 40, std::size_t{1} << 40), SceneError);
  CHECK_THROWS_AS(Distribution1D(Weights(kMaxCdfEntries + 1, 1.0f)), SceneError);
  CHECK_NOTHROW(Distribution2D(six, 2, 3));
}

TEST_CASE("Distribution1D: samples follow the values and report their own pdf") {
  for (const std::uint32_t count : {4u, 37u, 64u}) {
    const Weights values = uneven_weights(count);
    const Distribution1D d(values);
    CHECK(d.integral() == doctest::Approx(sum_of(values) / count));
    constexpr int kSamples = 300000;
    std::vector<double> observed(4 * count), expected(4 * count);
    int wrong = 0;
    for (int i = 0; i < kSamples; ++i) {
      const Sample1D<Scalar> s = d.sample<Scalar>(number(static_cast<std::uint32_t>(i)));
      observed[static_cast<std::size_t>(static_cast<double>(s.x) * 4 * count)] += 1.0;
      wrong += s.pdf != d.pdf<Scalar>(s.x) || cell_at<Scalar>(s.x, count) != s.index || !(values[s.index] > 0.0f);
    }
    CHECK(wrong == 0);
    for (std::size_t i = 0; i < expected.size(); ++i) expected[i] = values[i / 4] / sum_of(values) * kSamples / 4;
    CHECK(chi_square(observed, expected).p_value > significance_of_each(3));
  }
}

TEST_CASE("Distribution1D: the pdf is proportional to the values and integrates to one and advances in whole steps") {
  const Weights values = uneven_weights(1000);
  const Distribution1D d(values);
  const auto positive =
      static_cast<double>(std::count_if(values.begin(), values.end(), [](float v) { return v > 0.0f; }));
  double sum = 0;
  int wrong = 0;
  for (std::uint32_t i = 0; i < d.size(); ++i) {
    const double x = (i + 0.5) / d.size(), expected = values[i] / sum_of(values);
    const double steps = static_cast<double>(d.pdf<Scalar>(static_cast<float>(x))) / d.size() * 0x1p24;
    sum += steps;
    wrong += std::fabs(steps - std::round(steps)) > 1e-6 * steps || (steps > 0.0) != (values[i] > 0.0f);
    wrong += std::fabs(steps - expected * 0x1p24) > 2.0 + positive * expected;  // rounding, and one step per entry
  }
  CHECK(sum == doctest::Approx(0x1p24).epsilon(1e-6));
  CHECK(wrong == 0);
  CHECK(d.pdf<Scalar>(1.0f) == d.pdf<Scalar>(0.9999f));
  CHECK(d.pdf<Scalar>(-0.5f) == d.pdf<Scalar>(0.0f));
}

TEST_CASE("Distribution1D: samples are monotonic and stay in their cells and reach every positive value") {
  const Distribution1D tiny(Weights{1e-30f, 0.0f, 1.0f, 0.0f, 1e-30f});
  CHECK(tiny.sample<Scalar>(0.0f).index == 0);
  CHECK(tiny.sample<Scalar>(0x1p-24f).index == 2);
  CHECK(tiny.sample<Scalar>(kOneMinusEpsilon).index == 4);
  CHECK(tiny.sample<Scalar>(0.0f).pdf == 5 * 0x1p-24f);
  const Distribution1D single(Weights{7.0f});
  CHECK(single.sample<Scalar>(0.25f).x == doctest::Approx(0.25));
  CHECK(single.sample<Scalar>(kOneMinusEpsilon).x < 1.0f);
  CHECK(single.pdf<Scalar>(0.3f) == 1.0f);

  for (const std::uint32_t count : {49u, 1000u, 99991u, static_cast<std::uint32_t>(kMaxCdfEntries)}) {
    CAPTURE(count);
    const Weights values = uneven_weights(count);
    const Distribution1D d(values);
    float last = 0;
    int wrong = 0;
    for (std::uint32_t i = 0; i < 1u << 18; ++i) {
      const float u = i + 1 == 1u << 18 ? kOneMinusEpsilon : static_cast<float>(i) * 0x1p-18f;
      const Sample1D<Scalar> s = d.sample<Scalar>(u);
      wrong += s.x < last || !(s.x < 1.0f) || cell_at<Scalar>(s.x, count) != s.index || !(values[s.index] > 0.0f);
      last = s.x;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("Distribution1D and Distribution2D: SIMD results equal scalar ones") {
  const Distribution1D line(uneven_weights(77));
  const Distribution2D plane(uneven_weights(19 * 23), 19, 23);
  int wrong = 0;
  double worst = 0;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const auto u = [i](int lane) { return number(i + 1000u * static_cast<std::uint32_t>(lane)); };
    const auto v = [i](int lane) { return number(7 * i + static_cast<std::uint32_t>(lane)); };
    const Sample1D<Wide> a = line.sample<Wide>(wide_floats(u));
    const Sample2D<Wide> b = plane.sample<Wide>(wide_floats(u), wide_floats(v));
    const WideFloat a_pdf = line.pdf<Wide>(a.x), b_pdf = plane.pdf<Wide>(b.p);
    for (int lane = 0; lane < kWidth; ++lane) {
      const Sample1D<Scalar> p = line.sample<Scalar>(u(lane));
      const Sample2D<Scalar> q = plane.sample<Scalar>(u(lane), v(lane));
      wrong += a.index[lane] != p.index || a.pdf[lane] != p.pdf || a_pdf[lane] != p.pdf;
      wrong += b.column[lane] != q.column || b.row[lane] != q.row;
      worst =
          std::max({worst, difference(a.x[lane], p.x), difference(b.p.x[lane], q.p.x), difference(b.p.y[lane], q.p.y),
                    difference(b.pdf[lane], q.pdf), difference(b_pdf[lane], q.pdf)});
    }
  }
  CHECK(wrong == 0);
  CHECK(worst < 1e-6);
}

TEST_CASE("Distribution2D: samples follow the values with u for the column and v for the row") {
  constexpr int kWide = 12, kHigh = 8;
  Weights values = uneven_weights(kWide * kHigh);
  for (int x = 0; x < kWide; ++x) values[static_cast<std::size_t>(3 * kWide + x)] = 0.0f;  // a row of zeros
  const Distribution2D d(values, kWide, kHigh);
  CHECK(d.integral() == doctest::Approx(sum_of(values) / (kWide * kHigh)));
  int wrong = 0;
  const auto sample = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const Sample2D<Scalar> s = d.sample<Scalar>(u.x, u.y);
    wrong += s.pdf != d.pdf<Scalar>(s.p) || !(values[s.row * kWide + s.column] > 0.0f);
    return std::array<double, 2>{s.p.x, s.p.y};
  };
  const auto density = [&](double x, double y) {
    return values[static_cast<std::size_t>(y * kHigh) * kWide + static_cast<std::size_t>(x * kWide)] / d.integral();
  };
  const ChiSquare test = chi_square_plane(sample, density, {0, 1, 0, 1, 3 * kWide, 2 * kHigh});
  CHECK(wrong == 0);
  CHECK(test.integral == doctest::Approx(1.0));
  CHECK(test.p_value > kSignificance);

  const Distribution2D corner(Weights{0, 0, 1, 0, 0, 0}, 3, 2);
  CHECK(corner.sample<Scalar>(0.5f, 0.5f).column == 2);
  CHECK(corner.sample<Scalar>(0.5f, 0.5f).row == 0);
  CHECK(corner.sample<Scalar>(kOneMinusEpsilon, kOneMinusEpsilon).pdf == doctest::Approx(6.0));
  CHECK(corner.pdf<Scalar>({0.1f, 0.1f}) == 0.0f);
  CHECK(corner.pdf<Scalar>({0.9f, 0.9f}) == 0.0f);
  CHECK(corner.pdf<Scalar>({1.0f, 0.0f}) == doctest::Approx(6.0));
}

}  // namespace sheaf::test_distribution

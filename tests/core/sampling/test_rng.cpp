// Random numbers: uniform, independent for neighboring counters, and the same in every lane.
#include "core/sampling/rng.h"
#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <functional>
#include <string>
#include <unordered_set>
#include <utility>

namespace sheaf::test_rng {

namespace {

std::array<float, 4> numbers(std::uint32_t seed, std::uint32_t pixel, std::uint32_t sample, std::uint32_t block) {
  const Random4<Scalar> r = random4<Scalar>(seed, pixel, sample, block);
  return {r.x, r.y, r.z, r.w};
}

/// The four counters that determine a random number.
struct Counter {
  std::uint32_t seed, pixel, sample, block;
};
std::array<float, 4> numbers(Counter c) { return numbers(c.seed, c.pixel, c.sample, c.block); }

constexpr int kPairs = 1 << 18, kCells = 32;

/// p-value of a chi-square test for pairs of numbers on kCells x kCells cells.
double p_value_of_pairs(const std::function<std::array<float, 2>(std::uint32_t)>& pair) {
  std::vector<double> counts(kCells * kCells);
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    const auto [a, b] = pair(i);
    counts[static_cast<std::size_t>(a * kCells) * kCells + static_cast<std::size_t>(b * kCells)] += 1.0;
  }
  return chi_square_uniform(counts).p_value;
}

Counter at(std::uint32_t seed, std::uint32_t pixel, std::uint32_t sample, std::uint32_t block) {
  return {seed, pixel, sample, block};
}

using Neighbors = std::pair<Counter, Counter>;

/// A named family of neighboring counters.
struct Walk {
  std::string name;
  std::function<Neighbors(std::uint32_t)> pair;
};

/// A family in which the second counter is the first with one member changed.
template <class F>
Walk walk(const char* name, std::uint32_t Counter::*member, F&& change, Counter (*first)(std::uint32_t)) {
  return {name, [=](std::uint32_t i) {
            Neighbors pair{first(i), first(i)};
            pair.second.*member = change(pair.second.*member);
            return pair;
          }};
}

const std::vector<Walk>& walks() {
  using U = std::uint32_t;
  const auto next = [](U n) { return n + 1; };
  static const std::vector<Walk> all = {
      walk("neighboring pixels", &Counter::pixel, next, [](U i) { return at(0, 2 * i, 0, 0); }),
      walk("neighboring samples", &Counter::sample, next, [](U i) { return at(0, i / 32, 2 * (i % 32), 0); }),
      walk("samples of one pixel", &Counter::sample, next, [](U i) { return at(0, 1234, 2 * i, 0); }),
      walk("neighboring dimensions", &Counter::block, next, [](U i) { return at(0, i / 16, i % 16, 0); }),
      walk("dimensions of one path", &Counter::block, next, [](U i) { return at(0, 77, 5, 2 * i); }),
      walk("neighboring seeds", &Counter::seed, next, [](U i) { return at(0, i, 0, 0); }),
      walk("many seeds", &Counter::seed, next, [](U i) { return at(2 * i, 0, 0, 0); }),
      walk(
          "one path event apart", &Counter::block, [](U n) { return n + 3; }, [](U i) { return at(0, i, 0, 1); }),
      walk(
          "one row of pixels apart", &Counter::pixel, [](U n) { return n + 800; },
          [](U i) { return at(0, i % 800 + i / 800 * 1600, 3, 1); }),
      walk(
          "high bits of the pixel", &Counter::pixel, [](U n) { return n + (1u << 13); },
          [](U i) { return at(0, i << 14, 0, 0); }),
      walk(
          "seeds that differ in the highest bit", &Counter::seed, [](U n) { return n ^ 0x80000000u; },
          [](U i) { return at(1, i, 0, 0); }),
      walk(
          "pixel against minus pixel", &Counter::pixel, [](U n) { return 0u - n; },
          [](U i) { return at(0, i + 1, 0, 0); }),
      {"seed and pixel exchanged",
       [](U i) {
         return Neighbors{{i + 1, 0, 0, 0}, {0, i + 1, 0, 0}};
       }},
      {"pixel and sample exchanged",
       [](U i) {
         return Neighbors{{0, i + 1, 0, 0}, {0, 0, i + 1, 0}};
       }},
  };
  return all;
}

}  // namespace

TEST_CASE("rng: each of the four numbers is uniform along every counter") {
  const auto tests = static_cast<int>(walks().size()) * 4;
  for (const Walk& w : walks())
    for (std::size_t output = 0; output < 4; ++output) {
      CAPTURE(w.name);
      CAPTURE(output);
      std::vector<double> counts(1024);
      for (std::uint32_t i = 0; i < kPairs; ++i)
        counts[static_cast<std::size_t>(numbers(w.pair(i).first)[output] * 1024.0f)] += 1.0;
      CHECK(chi_square_uniform(counts).p_value > significance_of_each(tests));
    }
}

TEST_CASE("rng: neighboring counters are independent of each other") {
  const auto tests = static_cast<int>(walks().size()) * 4;
  for (const Walk& w : walks())
    for (std::size_t output = 0; output < 4; ++output) {
      CAPTURE(w.name);
      CAPTURE(output);
      const double p = p_value_of_pairs([&](std::uint32_t i) {
        const auto [a, b] = w.pair(i);
        return std::array<float, 2>{numbers(a)[output], numbers(b)[output]};
      });
      CHECK(p > significance_of_each(tests));
    }
}

TEST_CASE("rng: the four numbers of one call are independent of each other") {
  const auto tests = static_cast<int>(walks().size()) * 6;
  for (const Walk& w : walks())
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b) {
        CAPTURE(w.name);
        CAPTURE(a);
        CAPTURE(b);
        const double p = p_value_of_pairs([&](std::uint32_t i) {
          const auto r = numbers(w.pair(i).first);
          return std::array<float, 2>{r[a], r[b]};
        });
        CHECK(p > significance_of_each(tests));
      }
}

TEST_CASE("rng: a flip of any input bit flips every output bit with probability one half") {
  // The strict avalanche criterion, for all bits of seeds and pixels and the lower 24 bits of samples and blocks.
  constexpr std::uint32_t kTrials = 4096;
  constexpr int kBits[4] = {32, 32, 24, 24};
  constexpr int kTests = (32 + 32 + 24 + 24) * 4 * 24;
  int most = 0;  // maximum deviation of a flip count from its expectation
  for (std::size_t input = 0; input < 4; ++input)
    for (int bit = 0; bit < kBits[input]; ++bit) {
      int flips[4][24] = {};
      for (std::uint32_t i = 0; i < kTrials; ++i) {
        std::uint32_t counter[4] = {i % 5, 3 * i + 1, i & 15u, i % 7};
        const auto a = numbers(counter[0], counter[1], counter[2], counter[3]);
        counter[input] ^= 1u << bit;
        const auto b = numbers(counter[0], counter[1], counter[2], counter[3]);
        for (std::size_t k = 0; k < 4; ++k) {
          const auto changed = static_cast<std::uint32_t>(a[k] * 0x1p24f) ^ static_cast<std::uint32_t>(b[k] * 0x1p24f);
          for (int j = 0; j < 24; ++j) flips[k][j] += static_cast<int>(changed >> j & 1u);
        }
      }
      for (const auto& word : flips)
        for (const int n : word) most = std::max(most, std::abs(n - static_cast<int>(kTrials / 2)));
    }
  // Two-sided normal approximation of the binomial distribution: mean kTrials / 2, variance kTrials / 4.
  const double sigmas = most / std::sqrt(kTrials / 4.0);
  CHECK(std::erfc(sigmas / std::sqrt(2.0)) > significance_of_each(kTests));
}

TEST_CASE("rng: numbers are at least 0 and less than 1 and use all 24 bits") {
  CHECK(unit_float(0u) == 0.0f);
  CHECK(unit_float(0xffffffffu) == 0x1.fffffep-1f);
  CHECK(unit_float(0x80000000u) == 0.5f);
  CHECK(unit_float(0x000000ffu) == 0.0f);
  CHECK(unit_float(0x00000100u) == 0x1p-24f);
  for (const std::uint32_t bits : {0u, 0xffffffffu, 0x80000000u, 0x12345678u})
    CHECK(unit_float(WideUint(bits))[kWidth - 1] == unit_float(bits));
}

TEST_CASE("rng: SIMD numbers equal scalar ones to the bit") {
  int wrong = 0;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const auto pixel = [i](int lane) { return i * 977u + static_cast<std::uint32_t>(lane); };
    const auto sample = [i](int lane) { return i ^ static_cast<std::uint32_t>(lane * 5); };
    const auto block = [i](int lane) { return i % 7u + static_cast<std::uint32_t>(lane % 3); };
    const Random4<Wide> wide = random4<Wide>(i, wide_uints(pixel), wide_uints(sample), wide_uints(block));
    for (int lane = 0; lane < kWidth; ++lane) {
      const Random4<Scalar> one = random4<Scalar>(i, pixel(lane), sample(lane), block(lane));
      wrong += wide.x[lane] != one.x || wide.y[lane] != one.y || wide.z[lane] != one.z || wide.w[lane] != one.w;
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("rng: hash4 maps different counters to different words") {
  // hash4 is a bijection on 128 bits; even half of its output separates 2^18 counters.
  std::unordered_set<std::uint64_t> seen;
  for (std::uint32_t i = 0; i < 1u << 18; ++i) {
    std::uint32_t x = i % 64, y = i / 64 % 64, z = i / 4096 % 8, w = i / 32768;
    hash4(x, y, z, w);
    seen.insert(static_cast<std::uint64_t>(x) << 32 | y);
  }
  CHECK(seen.size() == 1u << 18);
}

}  // namespace sheaf::test_rng

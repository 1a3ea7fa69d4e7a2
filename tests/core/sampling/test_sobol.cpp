// The Sobol sequence: direction numbers, scrambling and shuffling.
#include "core/sampling/sobol.h"

#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <set>
#include <vector>

namespace sheaf::test_sobol {

namespace {

using U = std::uint32_t;
using Point = std::array<U, 5>;

Point sobol_point(U index) {
  Point p;
  sobol4<Scalar>(index, p.data());
  p[4] = sobol_fifth<Scalar>(index);
  return p;
}

/// Direction numbers by the recurrence of Sobol 1967, for a primitive polynomial of `degree` with inner coefficients
/// `a` and the initial numbers m; in units of 2^-32.
std::array<U, 32> direction_numbers(int degree, U a, const std::vector<U>& m) {
  std::array<U, 32> v{};
  for (int j = 0; j < 32; ++j) {
    const auto at = static_cast<std::size_t>(j);
    if (j < degree) {
      v[at] = m[at] << (31 - j);
      continue;
    }
    const U first = v[static_cast<std::size_t>(j - degree)];
    v[at] = first ^ (first >> degree);
    for (int k = 1; k < degree; ++k)
      if (a >> (degree - 1 - k) & 1u) v[at] ^= v[static_cast<std::size_t>(j - k)];
  }
  return v;
}

U combined(const std::array<U, 32>& v, U index) {
  U x = 0;
  for (int j = 0; j < 32; ++j)
    if (index >> j & 1u) x ^= v[static_cast<std::size_t>(j)];
  return x;
}

U mixed(U i) {
  U x = i, y = 1, z = 2, w = 3;
  hash4(x, y, z, w);
  return x;
}

}  // namespace

TEST_CASE("sobol: points match the direction numbers of Joe and Kuo") {
  const auto pascal = direction_numbers(1, 0, {1}), third = direction_numbers(2, 1, {1, 3}),
             fourth = direction_numbers(3, 1, {1, 3, 1}), fifth = direction_numbers(3, 2, {1, 1, 1});
  int wrong = 0;
  for (U n = 0; n < 200'000; ++n) {
    const U index = n < 100'000 ? n : mixed(n) >> (n % 32);
    const Point p = sobol_point(index);
    wrong += p[0] != index;  // van der Corput sequence: the bit-reversed index
    wrong += reverse_bits(p[1]) != combined(pascal, index);
    wrong += reverse_bits(p[2]) != combined(third, index);
    wrong += reverse_bits(p[3]) != combined(fourth, index);
    wrong += reverse_bits(p[4]) != combined(fifth, index);
  }
  CHECK(wrong == 0);
}

TEST_CASE("sobol: SIMD points equal scalar ones for small and large indices") {
  int wrong = 0;
  for (U n = 0; n < 4096; ++n) {
    const auto index = [n](int lane) { return mixed(n) >> (n + static_cast<U>(lane) * 5) % 32; };
    WideUint wide[5];
    sobol4<Wide>(wide_uints(index), wide);
    wide[4] = sobol_fifth<Wide>(wide_uints(index));
    for (int lane = 0; lane < kWidth; ++lane)
      for (std::size_t d = 0; d < 5; ++d) wrong += wide[d][lane] != sobol_point(index(lane))[d];
  }
  CHECK(wrong == 0);
}

TEST_CASE("sobol: scrambling is nested and keeps common low bits equal") {
  int wrong = 0;
  for (U n = 0; n < 20'000; ++n) {
    const U seed = mixed(3 * n), a = mixed(3 * n + 1);
    for (int bits = 0; bits < 32; ++bits) {
      const U low = (1u << bits) - 1u, b = (mixed(3 * n + 2) & ~low) | (a & low);
      wrong += ((owen_scramble(a, seed) ^ owen_scramble(b, seed)) & low) != 0;
      const U c = a ^ (1u << bits);
      wrong += (owen_scramble(a, seed) >> bits & 1u) == (owen_scramble(c, seed) >> bits & 1u);
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("sobol: scrambling flips each bit with probability one half independently of the lower bits") {
  // Bits 0 to 9 under each of the patterns below them: one binomial count for each node of the tree.
  constexpr int kBits = 10, kSeeds = 4096;
  double most = 0;
  for (int bit = 0; bit < kBits; ++bit)
    for (U pattern = 0; pattern < 1u << bit; ++pattern) {
      int flips = 0;
      for (U s = 0; s < kSeeds; ++s) flips += static_cast<int>(owen_scramble(pattern, mixed(s)) >> bit & 1u);
      most = std::max(most, std::fabs(flips - kSeeds / 2.0) / std::sqrt(kSeeds / 4.0));
    }
  CHECK(std::erfc(most / std::sqrt(2.0)) > significance_of_each((1 << kBits) - 1));
}

TEST_CASE("sobol: shuffling permutes each aligned run of 2^k indices and keeps leading zeros") {
  for (U key = 0; key < 50; ++key) {
    const U k0 = mixed(3 * key), k1 = mixed(3 * key + 1), k2 = mixed(3 * key + 2);
    for (int bits = 0; bits <= 10; ++bits) {
      std::set<U> first, other;
      for (U i = 0; i < 1u << bits; ++i) {
        first.insert(owen_shuffle(i, k0, k1, k2));
        other.insert(owen_shuffle(i + (77u << bits), k0, k1, k2));
      }
      CHECK(first.size() == 1u << bits);
      CHECK(*first.rbegin() == (1u << bits) - 1u);
      CHECK(other.size() == 1u << bits);
      CHECK((*other.begin() ^ *other.rbegin()) < 1u << bits);
    }
  }
}

TEST_CASE("sobol: every shuffle of the first indices that keeps leading zeros is equally probable") {
  // Among eight indices, 2, 4 and 6 choose freely: the order of 2 and 3, and the order of 4 to 7 with each half kept
  // together. That gives 2 * 8 shuffles.
  std::vector<double> counts(16);
  for (U key = 0; key < 1u << 16; ++key) {
    std::array<U, 8> order{};
    for (U i = 0; i < 8; ++i) order[i] = owen_shuffle(i, mixed(3 * key), mixed(3 * key + 1), mixed(3 * key + 2));
    const std::size_t which = (order[2] & 1u) | (order[4] & 3u) << 1 | (order[6] & 1u) << 3;
    counts[which] += 1.0;
  }
  CHECK(chi_square_uniform(counts).p_value > kSignificance);
}

TEST_CASE("sobol: the first 2^k samples fill every elementary interval in every pixel and block") {
  int wrong = 0;
  for (U pixel = 0; pixel < 40; ++pixel)
    for (int k = 0; k <= 12; k += pixel < 4 ? 1 : 3) {
      const U count = 1u << k;
      std::vector<Random4<Scalar>> samples;
      for (U i = 0; i < count; ++i) samples.push_back(sobol_random4<Scalar>({3, pixel, i}, pixel % 7));
      for (int split = 0; split <= k; ++split) {  // 2^split columns of x, 2^(k - split) rows of y
        std::vector<int> hits(count);
        for (const auto& s : samples) {
          const U column = to_uint(s.x * static_cast<float>(1u << split));
          const U row = to_uint(s.y * static_cast<float>(1u << (k - split)));
          ++hits[(row << split) + column];
        }
        for (const int n : hits) wrong += n != 1;
      }
      for (const float Random4<Scalar>::*member : {&Random4<Scalar>::z, &Random4<Scalar>::w}) {
        std::vector<int> hits(count);
        for (const auto& s : samples) ++hits[to_uint(s.*member * static_cast<float>(count))];
        for (const int n : hits) wrong += n != 1;
      }
    }
  CHECK(wrong == 0);
}

}  // namespace sheaf::test_sobol

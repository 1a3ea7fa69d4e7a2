// Stratified and correlated multi-jittered samples: permutations, cells, columns and rows.
#include "core/sampling/stratified.h"

#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

namespace sheaf::test_stratified {

namespace {

using U = std::uint32_t;

U key_of(U i) {
  U x = i, y = 1, z = 2, w = 3;
  hash4(x, y, z, w);
  return x;
}

constexpr SampleGrid kGrids[] = {{1, 1}, {2, 1}, {2, 2}, {3, 2}, {4, 3}, {8, 8}, {7, 5}, {16, 12}};

/// The index of the cell of (x, y) among grid.columns x grid.rows cells.
U cell_of(SampleGrid grid, float x, float y) {
  return to_uint(y * static_cast<float>(grid.rows)) * grid.columns + to_uint(x * static_cast<float>(grid.columns));
}

}  // namespace

TEST_CASE("stratified: permutations of any length visit every element once") {
  for (const U count : {1u, 2u, 3u, 4u, 5u, 7u, 8u, 9u, 12u, 31u, 64u, 100u, 1000u})
    for (U key = 0; key < 20; ++key) {
      std::vector<int> seen(count);
      for (U i = 0; i < count; ++i) ++seen.at(permuted(i, count, key_of(key)));
      CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
    }
}

TEST_CASE("stratified: pairs of elements are mapped to all pairs of positions with equal probability") {
  constexpr U kCounts[] = {2, 3, 4, 5, 6, 8, 12};
  for (const U count : kCounts) {
    CAPTURE(count);
    for (U a = 0; a < count; ++a) {
      const U b = (a + 1) % count;
      std::vector<double> positions(count * (count - 1));
      for (U key = 0; key < 1u << 14; ++key) {
        const U pa = permuted(a, count, key_of(key)), pb = permuted(b, count, key_of(key));
        positions[pa * (count - 1) + (pb > pa ? pb - 1 : pb)] += 1.0;
      }
      CHECK(chi_square_uniform(positions).p_value > significance_of_each(2 + 3 + 4 + 5 + 6 + 8 + 12));
    }
  }
}

TEST_CASE("stratified: division has the quotient and remainder of integers") {
  int wrong = 0;
  for (const U b : {1u, 2u, 3u, 7u, 64u, 1000u, 65537u, 1u << 24})
    for (U n = 0; n < 20'000; ++n) {
      const U a = n < 5000 ? n : n < 10'000 ? std::min((n - 5000) * b, (1u << 24) - 1) : key_of(n) >> 8;
      for (const U c : {a, a == 0 ? a : a - 1}) {
        const auto [quotient, remainder] = divide(c, b);
        wrong += quotient != c / b || remainder != c % b;
      }
    }
  CHECK(wrong == 0);
}

TEST_CASE("stratified: each cell of either plane gets one sample in every round") {
  for (const SampleGrid grid : kGrids)
    for (const bool correlated : {false, true})
      for (U round = 0; round < 3; ++round)
        for (U pixel = 0; pixel < 10; ++pixel) {
          std::vector<int> first(grid.size()), second(grid.size());
          for (U i = 0; i < grid.size(); ++i) {
            const auto u = stratified_random4<Scalar>(5, grid, correlated, pixel, round * grid.size() + i, pixel % 3);
            ++first.at(cell_of(grid, u.x, u.y));
            ++second.at(cell_of(grid, u.z, u.w));
          }
          CHECK(std::all_of(first.begin(), first.end(), [](int n) { return n == 1; }));
          CHECK(std::all_of(second.begin(), second.end(), [](int n) { return n == 1; }));
        }
}

TEST_CASE("stratified: multi-jittered samples also lie in different columns and rows") {
  for (const SampleGrid grid : kGrids)
    for (U pixel = 0; pixel < 50; ++pixel) {
      const U n = grid.size();
      std::vector<int> seen[4] = {std::vector<int>(n), std::vector<int>(n), std::vector<int>(n), std::vector<int>(n)};
      for (U i = 0; i < n; ++i) {
        const auto u = stratified_random4<Scalar>(5, grid, true, pixel, i, 1);
        int d = 0;
        for (const float x : {u.x, u.y, u.z, u.w}) ++seen[d++].at(to_uint(x * static_cast<float>(n)));
      }
      for (const auto& dimension : seen)
        CHECK(std::all_of(dimension.begin(), dimension.end(), [](int hits) { return hits == 1; }));
    }
}

TEST_CASE("stratified: SIMD numbers equal scalar ones to the bit") {
  int wrong = 0;
  for (const SampleGrid grid : kGrids)
    for (const bool correlated : {false, true})
      for (U i = 0; i < 200; ++i) {
        const auto pixel = [i](int lane) { return i * 977u + static_cast<U>(lane); };
        const auto sample = [i](int lane) { return i ^ static_cast<U>(lane * 5); };
        const auto wide =
            stratified_random4<Wide>(i, grid, correlated, wide_uints(pixel), wide_uints(sample), WideUint(3u));
        for (int lane = 0; lane < kWidth; ++lane) {
          const auto one = stratified_random4<Scalar>(i, grid, correlated, pixel(lane), sample(lane), 3u);
          wrong += wide.x[lane] != one.x || wide.y[lane] != one.y || wide.z[lane] != one.z || wide.w[lane] != one.w;
        }
      }
  CHECK(wrong == 0);
}

}  // namespace sheaf::test_stratified

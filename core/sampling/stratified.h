// Stratified sampling: in each pair of dimensions, the samples of a pixel are distributed over the cells of a grid. The
// assignment of samples to cells is shuffled for each pixel, block and pair.
#pragma once

#include "core/sampling/rng.h"

namespace sheaf {

/// The grid of cells in a pair of dimensions, one cell for each sample.
struct SampleGrid {
  std::uint32_t columns = 1, rows = 1;
  std::uint32_t size() const { return columns * rows; }
};

/// Element `i` of the permutation of 0 .. count - 1 that `key` selects; i is below count. Permutes the next power of
/// two and follows the cycle until the element is below count (Kensler, "Correlated Multi-Jittered Sampling", 2013).
template <class U> SHEAF_INLINE U permuted(U i, std::uint32_t count, U key) {
  const int bits = static_cast<int>(std::bit_width(count - 1)), half = std::max(1, (bits + 1) / 2);
  const U mask((1u << bits) - 1u), end(count);
  const auto step = [&](U x) SHEAF_LAMBDA_INLINE {
    for (int round = 0; round < 6; ++round) {
      x = ((x + (key >> 5 * round)) * ((key >> (27 - 5 * round)) | U(1u))) & mask;
      x = x ^ ((x >> 1) & (key >> (3 + 4 * round)));
      x = x ^ (x >> half);
    }
    return x;
  };
  i = step(i);
  for (auto outside = !(i < end); any(outside); outside = !(i < end)) i = select(outside, step(i), i);
  return i;
}

/// Quotient and remainder.
template <class U> struct Division { U quotient, remainder; };

/// a / b and its remainder for a below 2^24.
template <class U> SHEAF_INLINE Division<U> divide(U a, std::uint32_t b) {
  using F = decltype(to_float(a));
  const U guess = to_uint(to_float(a) * F(1.0f / static_cast<float>(b)));  // off by one at most
  const U product = guess * U(b);
  const U quotient = select(a < product, guess - U(1u), select(a - product < U(b), guess, guess + U(1u)));
  return {quotient, a - quotient * U(b)};
}

namespace stratified_detail {

template <class L> struct Pair { typename L::Float x, y; };

/// A point in `cell`, jittered by (u, v). `correlated`: within a column, points lie in different rows of a finer grid,
/// and likewise within a row. Each of the finer rows and columns then holds one point.
template <class L>
SHEAF_INLINE Pair<L> point_in_cell(SampleGrid grid, typename L::Uint cell, bool correlated, typename L::Uint key_x,
                                   typename L::Uint key_y, typename L::Float u, typename L::Float v) {
  using F = typename L::Float;
  const auto [row, column] = divide(cell, grid.columns);
  const F width(1.0f / static_cast<float>(grid.columns)), height(1.0f / static_cast<float>(grid.rows)), one(1.0f);
  const F last(kOneMinusEpsilon);
  if (correlated) {
    u = to_float(permuted(row, grid.rows, key_y)) + u;
    v = to_float(permuted(column, grid.columns, key_x)) + v;
  }
  const F x = fma(u, correlated ? height : one, to_float(column)), y = fma(v, correlated ? width : one, to_float(row));
  return {min(x * width, last), min(y * height, last)};
}

}  // namespace stratified_detail

/// Four numbers of a sample. (x, y) and (z, w) each lie in a cell of a grid of their own. grid.size() consecutive
/// samples, beginning at a multiple of it, fill all cells. `correlated`: correlated multi-jittered (Kensler 2013), else
/// jittered. Samples are below 2^24.
template <class L>
SHEAF_INLINE Random4<L> stratified_random4(std::uint32_t seed, SampleGrid grid, bool correlated, typename L::Uint pixel,
                                           typename L::Uint sample, typename L::Uint block) {
  using U = typename L::Uint;
  constexpr std::uint32_t kStream = 0xb5297a4du;  // keeps the keys distinct from the numbers of random4
  const Random4<L> jitter = random4<L>(seed, pixel, sample, block);
  const auto [round, i] = divide(sample, grid.size());
  stratified_detail::Pair<L> pairs[2];
  for (std::uint32_t p = 0; p < 2; ++p) {
    U k0 = pixel ^ (pixel >> 16), k1 = round * U(2u) + U(p + kStream), k2 = block, k3 = U(seed ^ (seed >> 16));
    hash4(k0, k1, k2, k3);
    pairs[p] = stratified_detail::point_in_cell<L>(grid, permuted(i, grid.size(), k0), correlated, k1, k2,
                                                   p == 0 ? jitter.x : jitter.z, p == 0 ? jitter.y : jitter.w);
  }
  return {pairs[0].x, pairs[0].y, pairs[1].x, pairs[1].y};
}

}  // namespace sheaf

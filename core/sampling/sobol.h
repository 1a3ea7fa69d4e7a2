// The first five dimensions of the Sobol sequence with nested uniform (Owen) scrambling, without tables.
//
// A dimension with primitive polynomial p of degree e has direction numbers v_j with v_{j+e} + ... + v_j = v_j >> e.
// The left side is p applied to the shift E: v_j -> v_{j+1} (Sobol 1967). So p(E)^k v_0 = v_0 >> ek. A point is i(E)
// v_0, where i(t) is the index as a polynomial over GF(2), and bit j is the coefficient of t^j. Expanded in powers of
// p, i is sum r_k p^k with deg r_k < e, and the point is sum (r_k(E) v_0) >> ek. The digits r_k stand side by side, and
// only the initial direction numbers remain. The expansion divides by p^(2^k) = p(t^(2^k)) with remainder for each k,
// largest first, for all digits at once. Each division is a few shifts, since p has few terms. For p = t + 1 the result
// is the Pascal matrix.
//
// Words here are bit-reversed fractions: bit 0 is worth 1/2. Laine-Karras hashes scramble in this order.
#pragma once

#include "core/sampling/rng.h"

namespace sheaf {

namespace sobol_detail {

/// A mask of ones in the parts `first` to `last` of each run of `parts` parts of `width` bits.
constexpr std::uint32_t part_mask(int parts, int width, int first, int last) {
  std::uint32_t mask = 0;
  for (int bit = 0; bit < 32; ++bit) {
    const int part = bit / width % parts;
    if (part >= first && part <= last) mask |= 1u << bit;
  }
  return mask;
}

/// Divides runs of 2 s bits, s = `kShift`, by t^s + 1. The quotient is in the upper half, the remainder in the lower
/// half.
template <int kShift, class U> SHEAF_INLINE U divide_by_1(U i) {
  return i ^ ((i >> kShift) & U(part_mask(2, kShift, 0, 0)));
}

/// Divides runs of 4 s bits, s = `kShift`, by t^2s + t^s + 1.
template <int kShift, class U> SHEAF_INLINE U divide_by_2(U i) {
  i = i ^ ((i >> kShift) & U(part_mask(4, kShift, 1, 2)));
  return i ^ ((i >> 2 * kShift) & U(part_mask(4, kShift, 0, 0)));
}

/// Divides runs of 6 s bits, s = `kShift`, by t^3s + t^s + 1.
template <int kShift, class U> SHEAF_INLINE U divide_by_3(U i) {
  i = i ^ ((i >> 2 * kShift) & U(part_mask(6, kShift, 3, 3)));
  return i ^ ((i >> 3 * kShift) & U(part_mask(6, kShift, 0, 2))) ^ ((i >> 2 * kShift) & U(part_mask(6, kShift, 1, 2)));
}

/// Divides runs of 6 s bits, s = `kShift`, by t^3s + t^2s + 1.
template <int kShift, class U> SHEAF_INLINE U divide_by_4(U i) {
  i = i ^ ((i >> kShift) & U(part_mask(6, kShift, 4, 4)));
  i = i ^ ((i >> kShift) & U(part_mask(6, kShift, 3, 3)));
  return i ^ ((i >> 3 * kShift) & U(part_mask(6, kShift, 0, 2))) ^ ((i >> kShift) & U(part_mask(6, kShift, 2, 2)));
}

}  // namespace sobol_detail

/// Point `index` of the Sobol sequence, dimensions 1 to 4, as bit-reversed fractions. The direction numbers are those
/// of Joe and Kuo, "Constructing Sobol Sequences with Better Two-Dimensional Projections", 2008. Dimensions 3 and 4 are
/// computed only if `requested` (RandomNumbers) includes them.
template <class L>
SHEAF_INLINE void sobol4(typename L::Uint index, typename L::Uint out[4], unsigned requested = kAllNumbers) {
  using U = typename L::Uint;
  using namespace sobol_detail;
  // Expand the index in powers of the primitive polynomials of dimensions 2 to 4
  U a = index, b = index, c = index;
  // Large divisors do not change small indices.
  if (any((index >> 8) != U(0u))) {
    if (any((index >> 16) != U(0u))) {
      a = divide_by_1<16>(a);
      b = divide_by_2<8>(b);
      c = divide_by_3<8>(c);
    }
    a = divide_by_1<8>(a);
    b = divide_by_2<4>(b);
    c = divide_by_3<4>(c);
  }
  out[0] = index;
  out[1] = divide_by_1<1>(divide_by_1<2>(divide_by_1<4>(a)));
  // Initial direction numbers 1/2, 3/4 and 1/2, 3/4, 1/8.
  if ((requested & kNumberZ) != 0) {
    b = divide_by_2<1>(divide_by_2<2>(b));
    out[2] = b ^ ((b >> 1) & U(part_mask(2, 1, 0, 0)));
  }
  if ((requested & kNumberW) != 0) {
    c = divide_by_3<1>(divide_by_3<2>(c));
    out[3] = c ^ ((c >> 1) & U(part_mask(3, 1, 0, 0)));
  }
}

/// The fifth dimension of the same sequence.
template <class L> SHEAF_INLINE typename L::Uint sobol_fifth(typename L::Uint index) {
  using U = typename L::Uint;
  using namespace sobol_detail;
  U d = index;
  if (any((index >> 8) != U(0u))) {
    if (any((index >> 16) != U(0u))) d = divide_by_4<8>(d);
    d = divide_by_4<4>(d);
  }
  return divide_by_4<1>(divide_by_4<2>(d));  // initial direction numbers 1/2, 1/4, 1/8
}

/// Nested uniform scrambling of a bit-reversed fraction: whether a bit is flipped depends on the seed and the bits
/// below it. Laine and Karras, "Stratified Sampling for Stochastic Transparency", EGSR 2011, in the improved form of
/// Vegdahl, "Building a Better LK Hash", 2021.
template <class U> SHEAF_INLINE U owen_scramble(U x, U seed) {
  x = x ^ (x * U(0x3d20adeau));
  x = x + seed;
  x = x * ((seed >> 16) | U(1u));
  x = x ^ (x * U(0x05526c56u));
  return x ^ (x * U(0x53a22864u));
}

/// A nested uniform shuffle of an index: whether a bit is flipped depends on the keys and the bits above it. So aligned
/// runs of 2^k indices stay together. Leading zeros stay zeros: the first 2^k indices are shuffled among themselves,
/// for any length of the sequence. This loses no randomness: flipping a bit of all indices flips bits of all points
/// alike, which their scrambling does anyway.
template <class U> SHEAF_INLINE U owen_shuffle(U index, U key0, U key1, U key2) {
  U x = reverse_bits(index);
  x = x ^ ((x << 1) & key1);
  x = x * (key0 | U(1u));
  x = x ^ (x * (key1 & U(~1u)));
  return reverse_bits(x * (key2 | U(1u)));
}

/// A point of one of many Sobol sequences, which are shuffled and scrambled independently for each seed, `sequence` and
/// block of dimensions (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020).
template <class L> struct SobolPoint { typename L::Uint seed, sequence, index; };

namespace sobol_detail {

template <class L> struct Keys {
  typename L::Uint scramble[4];

  SHEAF_INLINE Keys(const SobolPoint<L>& at, typename L::Uint block) {
    using U = typename L::Uint;
    constexpr std::uint32_t kStream = 0x68bc21ebu;  // keeps the keys distinct from the numbers of random4
    U k0 = at.sequence ^ (at.sequence >> 16), k1 = U(kStream), k2 = block, k3 = at.seed ^ (at.seed >> 16);
    hash4(k0, k1, k2, k3);
    const U keys[4] = {k0, k1, k2, k3};
    for (int i = 0; i < 4; ++i) scramble[i] = keys[i] ^ (keys[i] >> 16);  // scrambling needs good lower bits
  }
  /// Shuffles by key bits that hardly affect scrambling: the scrambling must be independent of the index in the
  /// sequence.
  SHEAF_INLINE typename L::Uint shuffle(typename L::Uint index) const {
    using U = typename L::Uint;
    return owen_shuffle(index, scramble[0] >> 8, (scramble[1] >> 8) | (scramble[3] & U(0xff000000u)), scramble[2] >> 8);
  }
};

template <class U> SHEAF_INLINE auto scrambled_float(U fraction, U key) {
  return unit_float(reverse_bits(owen_scramble(fraction, key)));
}

}  // namespace sobol_detail

/// Four numbers of a point. The first 2^k points of a sequence put one point into each of the 2^k equal intervals of
/// any dimension, and into each of 2^k equal elementary rectangles of (x, y). Numbers that are not `requested`
/// (RandomNumbers) are undefined.
template <class L>
SHEAF_INLINE Random4<L> sobol_random4(const SobolPoint<L>& at, typename L::Uint block,
                                      unsigned requested = kAllNumbers) {
  using namespace sobol_detail;
  // Shuffle the index and compute the point
  const Keys<L> keys(at, block);
  typename L::Uint point[4];
  sobol4<L>(keys.shuffle(at.index), point, requested);
  // Scramble each number by a key of its own
  const typename L::Float any(0.0f);
  Random4<L> u{any, any, any, any};
  if ((requested & kNumberX) != 0) u.x = scrambled_float(point[0], keys.scramble[0]);
  if ((requested & kNumberY) != 0) u.y = scrambled_float(point[1], keys.scramble[1]);
  if ((requested & kNumberZ) != 0) u.z = scrambled_float(point[2], keys.scramble[2]);
  if ((requested & kNumberW) != 0) u.w = scrambled_float(point[3], keys.scramble[3]);
  return u;
}

/// A fifth number that belongs to the four of `block`: points with similar fifth numbers are well stratified in the
/// four. `own_block`: a block of its own, by which it is scrambled.
template <class L>
SHEAF_INLINE typename L::Float sobol_random_fifth(const SobolPoint<L>& at, typename L::Uint block,
                                                  typename L::Uint own_block) {
  using namespace sobol_detail;
  return scrambled_float(sobol_fifth<L>(Keys<L>(at, block).shuffle(at.index)), Keys<L>(at, own_block).scramble[0]);
}

}  // namespace sheaf

// Counter-based random numbers: pure functions of (seed, pixel, sample, dimension) without state.
#pragma once

#include "core/simd/lanes.h"

namespace sheaf {

/// Four uniform numbers in [0, 1).
template <class L> struct Random4 { typename L::Float x, y, z, w; };

/// Bit mask of the numbers of a Random4.
enum RandomNumbers : unsigned { kNumberX = 1, kNumberY = 2, kNumberZ = 4, kNumberW = 8, kAllNumbers = 15 };

/// A uniform number in [0, 1) from the upper 24 bits.
template <class U> SHEAF_INLINE auto unit_float(U bits) { return to_float(bits >> 8) * 5.9604644775390625e-8f; }

/// Hashes four 32-bit words to four independent ones: pcg4d of Jarzynski and Olano, "Hash Functions for GPU Rendering",
/// JCGT 2020.
template <class U> SHEAF_INLINE void hash4(U& x, U& y, U& z, U& w) {
  x = x * U(1664525u) + U(1013904223u);
  y = y * U(1664525u) + U(1013904223u);
  z = z * U(1664525u) + U(1013904223u);
  w = w * U(1664525u) + U(1013904223u);
  for (int round = 0; round < 2; ++round) {
    x = x + y * w;
    y = y + z * x;
    z = z + x * y;
    w = w + y * z;
    if (round == 1) break;
    x = x ^ (x >> 16);
    y = y ^ (y >> 16);
    z = z ^ (z >> 16);
    w = w ^ (w >> 16);
  }
}

/// Four uniform numbers for one block of dimensions (see core/sampling/sampler.h) of one sample of one pixel. hash4
/// propagates changes well to higher bits, but bits 25 to 31 of a word hardly affect the others. So seeds and pixels,
/// which may be large, are folded first. Samples and blocks should stay below 2^24.
template <class L>
SHEAF_INLINE Random4<L> random4(std::uint32_t seed, typename L::Uint pixel, typename L::Uint sample,
                                typename L::Uint block) {
  typename L::Uint x = pixel ^ (pixel >> 16), y = sample, z = block, w = typename L::Uint(seed ^ (seed >> 16));
  hash4(x, y, z, w);
  return {unit_float(x), unit_float(y), unit_float(z), unit_float(w)};
}

}  // namespace sheaf

// Random numbers for tracking and for manifold walks, which need an unbounded number: a counter-based stream per ray.
#pragma once

#include "core/sampling/rng.h"

#include <tuple>

namespace sheaf {

/// Use of a stream. Streams of different uses are independent of each other and of the blocks of
/// core/sampling/sampler.h.
enum class MediumStream : std::uint32_t {
  kPath = 0x6d656469u,
  kShadow = 0x73686164u,
  kSegment = 0x7365676du,
  kCaustics = 0x63617573u
};

/// Uniform numbers in [0, 1), a pure function of (seed, pixel, sample, dimension, use).
class MediumRandom {
 public:
  MediumRandom(std::uint32_t seed, std::uint32_t pixel, std::uint32_t sample, std::uint32_t dimension, MediumStream use)
      : pixel_(pixel ^ (pixel >> 16)),
        sample_(sample),
        dimension_(dimension),
        key_(seed ^ (seed >> 16) ^ static_cast<std::uint32_t>(use)) {}

  SHEAF_INLINE float next() {
    if (left_ == 0) refill();
    return numbers_[--left_];
  }

 private:
  void refill() {
    std::uint32_t x = pixel_, y = sample_, z = dimension_, w = key_ + 0x9e3779b9u * counter_++;
    hash4(x, y, z, w);
    // Second round: fold the high bits into the low ones, because one round does not propagate all bits.
    x ^= x >> 15, y ^= y >> 15, z ^= z >> 15, w ^= w >> 15;
    hash4(x, y, z, w);
    numbers_[0] = unit_float(x);
    numbers_[1] = unit_float(y);
    numbers_[2] = unit_float(z);
    numbers_[3] = unit_float(w);
    left_ = 4;
  }

  std::uint32_t pixel_, sample_, dimension_, key_, counter_ = 0;
  int left_ = 0;
  float numbers_[4];
};

/// Key of a stream of such numbers, one per lane. The numbers differ from those of MediumRandom.
template <class L> struct MediumNumbers {
  Uint<L> x, y, z, w;
  static constexpr auto fields(auto& s) { return std::tie(s.x, s.y, s.z, s.w); }

  /// `pixel`, `sample` and `dimension` as for MediumRandom.
  static SHEAF_INLINE MediumNumbers start(Uint<L> pixel, Uint<L> sample, Uint<L> dimension, Uint<L> key) {
    MediumNumbers n{pixel ^ (pixel >> 16), sample, dimension, key};
    hash4(n.x, n.y, n.z, n.w);
    return n;
  }
  static std::uint32_t key(std::uint32_t seed, MediumStream use) {
    return seed ^ (seed >> 16) ^ static_cast<std::uint32_t>(use);
  }

  /// The four numbers with index `counter`.
  SHEAF_INLINE Random4<L> at(Uint<L> counter) const {
    Uint<L> a = x ^ (x >> 15), b = y ^ (y >> 15), c = z ^ (z >> 15), d = w + Uint<L>(0x9e3779b9u) * counter;
    d = d ^ (d >> 15);
    hash4(a, b, c, d);
    return {unit_float(a), unit_float(b), unit_float(c), unit_float(d)};
  }
};

}  // namespace sheaf

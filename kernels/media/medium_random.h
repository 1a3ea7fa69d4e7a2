// Random numbers for tracking, which needs any number of them: a counter-based stream per ray.
#pragma once

#include "core/rng.h"

namespace sheaf {

/// What a stream is for: streams of different uses are independent of each other and of core/sampler.h's blocks.
enum class MediumStream : std::uint32_t { kPath = 0x6d656469u, kShadow = 0x73686164u };

/// Uniform numbers in [0, 1), a pure function of (seed, pixel, sample, event, use).
class MediumRandom {
 public:
  MediumRandom(std::uint32_t seed, std::uint32_t pixel, std::uint32_t sample, std::uint32_t event, MediumStream use)
      : pixel_(pixel ^ (pixel >> 16)),
        sample_(sample),
        event_(event),
        key_(seed ^ (seed >> 16) ^ static_cast<std::uint32_t>(use)) {}

  SHEAF_INLINE float next() {
    if (left_ == 0) refill();
    return numbers_[--left_];
  }

 private:
  void refill() {
    std::uint32_t x = pixel_, y = sample_, z = event_, w = key_ + 0x9e3779b9u * counter_++;
    hash4(x, y, z, w);
    // Once more, with what the low bits of one word have not reached.
    x ^= x >> 15, y ^= y >> 15, z ^= z >> 15, w ^= w >> 15;
    hash4(x, y, z, w);
    numbers_[0] = unit_float(x);
    numbers_[1] = unit_float(y);
    numbers_[2] = unit_float(z);
    numbers_[3] = unit_float(w);
    left_ = 4;
  }

  std::uint32_t pixel_, sample_, event_, key_, counter_ = 0;
  int left_ = 0;
  float numbers_[4];
};

}  // namespace sheaf

// The four spectral lanes of one path in one register, for code in which paths diverge, such as tracking through media.
#pragma once

#include "core/color/spectrum.h"

namespace sheaf {

/// Four floats.
struct Float4 {
  Float4Batch v;
  SHEAF_INLINE Float4() : v(0.0f) {}
  SHEAF_INLINE explicit Float4(float x) : v(x) {}
  SHEAF_INLINE Float4(Float4Batch b) : v(b) {}
  SHEAF_INLINE explicit Float4(const Spectrum4& s) : v(load(&s.c0).v) {}

  /// Loads four consecutive floats. `p` needs no alignment.
  static SHEAF_INLINE Float4 load(const float* p) { return Float4Batch::load_unaligned(p); }
  SHEAF_INLINE void store(float* p) const { v.store_unaligned(p); }
  SHEAF_INLINE float operator[](int lane) const {
    float lanes[4];
    store(lanes);
    return lanes[lane];
  }
};
static_assert(sizeof(Spectrum4) == 4 * sizeof(float));

SHEAF_INLINE Spectrum4 to_spectrum(Float4 a) {
  Spectrum4 s;
  a.store(&s.c0);
  return s;
}

SHEAF_INLINE Float4 operator+(Float4 a, Float4 b) { return a.v + b.v; }
SHEAF_INLINE Float4 operator-(Float4 a, Float4 b) { return a.v - b.v; }
SHEAF_INLINE Float4 operator*(Float4 a, Float4 b) { return a.v * b.v; }
SHEAF_INLINE Float4 operator*(Float4 a, float s) { return a.v * Float4Batch(s); }
SHEAF_INLINE Float4 operator/(Float4 a, Float4 b) { return batch::divide(a.v, b.v); }
SHEAF_INLINE Float4 max(Float4 a, Float4 b) { return batch::max(a.v, b.v); }
SHEAF_INLINE Float4 min(Float4 a, Float4 b) { return batch::min(a.v, b.v); }
SHEAF_INLINE Float4 sqrt(Float4 a) { return batch::sqrt(a.v); }
SHEAF_INLINE Float4 exp(Float4 a) { return xsimd::exp(a.v); }

/// The sum of all four lanes.
SHEAF_INLINE float total(Float4 a) {
  float x[4];
  a.store(x);
  return (x[0] + x[1]) + (x[2] + x[3]);
}
SHEAF_INLINE float max_component(Float4 a) {
  float x[4];
  a.store(x);
  return max(max(x[0], x[1]), max(x[2], x[3]));
}

}  // namespace sheaf

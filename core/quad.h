// Four spectral lanes in one register: for code whose paths go separate ways, such as tracking through media.
#pragma once

#include "core/spectrum.h"

namespace sheaf {

/// Four floats.
struct Quad {
  QuadBatch v;
  SHEAF_INLINE Quad() : v(0.0f) {}
  SHEAF_INLINE explicit Quad(float x) : v(x) {}
  SHEAF_INLINE Quad(QuadBatch b) : v(b) {}
  SHEAF_INLINE explicit Quad(const Spectrum4& s) : v(load(&s.c0).v) {}

  /// Four adjacent floats, anywhere.
  static SHEAF_INLINE Quad load(const float* p) { return QuadBatch::load_unaligned(p); }
  SHEAF_INLINE void store(float* p) const { v.store_unaligned(p); }
  SHEAF_INLINE float operator[](int lane) const {
    float lanes[4];
    store(lanes);
    return lanes[lane];
  }
};
static_assert(sizeof(Spectrum4) == 4 * sizeof(float));

SHEAF_INLINE Spectrum4 to_spectrum(Quad a) {
  Spectrum4 s;
  a.store(&s.c0);
  return s;
}

SHEAF_INLINE Quad operator+(Quad a, Quad b) { return a.v + b.v; }
SHEAF_INLINE Quad operator-(Quad a, Quad b) { return a.v - b.v; }
SHEAF_INLINE Quad operator*(Quad a, Quad b) { return a.v * b.v; }
SHEAF_INLINE Quad operator*(Quad a, float s) { return a.v * QuadBatch(s); }
SHEAF_INLINE Quad operator/(Quad a, Quad b) { return a.v / b.v; }
SHEAF_INLINE Quad max(Quad a, Quad b) { return xsimd::max(a.v, b.v); }
SHEAF_INLINE Quad min(Quad a, Quad b) { return xsimd::min(a.v, b.v); }
SHEAF_INLINE Quad sqrt(Quad a) { return xsimd::sqrt(a.v); }
SHEAF_INLINE Quad exp(Quad a) { return xsimd::exp(a.v); }

/// The sum of the four.
SHEAF_INLINE float total(Quad a) {
  float x[4];
  a.store(x);
  return (x[0] + x[1]) + (x[2] + x[3]);
}
SHEAF_INLINE float max_component(Quad a) {
  float x[4];
  a.store(x);
  return max(max(x[0], x[1]), max(x[2], x[3]));
}

}  // namespace sheaf

// Uniform sampling of the directions from a point to a rectangle (Urena, Fajardo and King, "An Area-Preserving
// Parametrization for Spherical Rectangles", 2013). Sums of angles are products of complex numbers, so that the solid
// angle takes a single arc tangent.
#pragma once

#include "core/math/inverse_sqrt.h"
#include "core/sampling/warp.h"

namespace sheaf {

/// A rectangle seen from the origin, with sides along x and y, at a distance along z.
template <class L> class SphericalRectangle {
  using F = typename L::Float;

 public:
  /// The rectangle [x0, x1] x [y0, y1] at the distance `height` >= 0, in any unit of length. Not all may be 0.
  SHEAF_INLINE SphericalRectangle(F x0, F x1, F y0, F y1, F height) {
    // Scale the largest coordinate to 1 to 2
    const F largest = max(max(max(abs(x0), abs(x1)), max(abs(y0), abs(y1))), height);
    const Uint<L> exponent = float_bits(largest) & Uint<L>(0x7f800000u);
    scale_ = bits_float(Uint<L>(0x7f000000u) - exponent);
    unit_ = bits_float(exponent);
    x0_ = x0 * scale_, x1_ = x1 * scale_, y0_ = y0 * scale_, y1_ = y1 * scale_, h_ = height * scale_;
    // Sum the solid angles between the axes and the corners
    left_ = corner(x0_, y1_) - corner(x0_, y0_);
    solid_angle_ = radians(corner(x1_, y1_) - corner(x1_, y0_) - left_);
  }

  /// Solid angle in sr, 0 to 2 pi. Absolute error: about 1e-6.
  SHEAF_INLINE F solid_angle() const { return solid_angle_; }

  /// The point in a uniformly distributed direction, relative to the corner (x0, y0). `u`, `v`: uniform in [0, 1).
  /// Undefined if solid angle or distance are 0.
  SHEAF_INLINE Vec2<L> sample(F u, F v) const {
    const F one(1.0f), h2 = h_ * h_;
    // x: the angle a = k + u * solid angle, where k is pi plus that of left_ (section 3.2)
    const F r0 = inverse_sqrt<L>(y0_ * y0_ + h2), r1 = inverse_sqrt<L>(y1_ * y1_ + h2);
    const F k_scale = -inverse_sqrt<L>(left_.cos * left_.cos + left_.sin * left_.sin);
    const auto azimuth = sincos_2pi<L>(u * solid_angle_ * F(0.5f * kInvPi));
    const Angle a = Angle{azimuth.cos, azimuth.sin} + Angle{left_.cos * k_scale, left_.sin * k_scale};
    const F n = -(a.cos * y0_ * r0 + y1_ * r1), d = a.sin * h_ * r0;
    const F scaled = h_ * a.sin * copysign(one, n) * inverse_sqrt<L>(max(n * n - d * d, F(1e-30f)));
    const F x = clamp(scaled, x0_, x1_);
    // y: the sine of its angle is uniform
    const F squared = x * x + h2, sine0 = sine(y0_, squared), sine1 = sine(y1_, squared);
    const F s = sine0 + v * (sine1 - sine0), cos2 = max(one - s * s, F(1e-12f));
    const F y = clamp(s * squared * inverse_sqrt<L>(squared * cos2), y0_, y1_);
    return {(x - x0_) * unit_, (y - y0_) * unit_};
  }

  /// The numbers u and v with which sample() returns the point `at`.
  SHEAF_INLINE Vec2<L> invert(Vec2<L> at) const {
    const F zero(0.0f), one(1.0f);
    const F x = x0_ + at.x * scale_, y = y0_ + at.y * scale_, squared = x * x + h_ * h_;
    const F u = radians(corner(x, y1_) - corner(x, y0_) - left_) / solid_angle_;
    const F sine0 = sine(y0_, squared), v = (sine(y, squared) - sine0) / (sine(y1_, squared) - sine0);
    return {clamp(u, zero, one), clamp(v, zero, one)};
  }

  /// Scalar products of `n` and the unit vectors to the corners, in the order of CornerWeights. Relative error: 1e-4.
  SHEAF_INLINE CornerWeights<L> corner_cosines(Vec3<L> n) const {
    const auto at = [&](F x, F y) SHEAF_LAMBDA_INLINE {
      return (n.x * x + n.y * y + n.z * h_) * rough_inverse_sqrt<L>(x * x + y * y + h_ * h_ + F(1e-30f));
    };
    return {at(x0_, y0_), at(x1_, y0_), at(x0_, y1_), at(x1_, y1_)};
  }

 private:
  /// Cosine and sine of an angle, times any positive factor.
  struct Angle {
    F cos, sin;
    SHEAF_INLINE Angle operator+(Angle b) const { return {cos * b.cos - sin * b.sin, sin * b.cos + cos * b.sin}; }
    SHEAF_INLINE Angle operator-(Angle b) const { return {cos * b.cos + sin * b.sin, sin * b.cos - cos * b.sin}; }
  };

  /// Signed solid angle between (0, 0) and (x, y).
  SHEAF_INLINE Angle corner(F x, F y) const {
    const F squared = x * x + y * y + h_ * h_ + F(1e-30f);
    return {h_ * squared * inverse_sqrt<L>(squared), x * y};
  }
  /// In [0, 2 pi).
  static SHEAF_INLINE F radians(Angle a) {
    const F angle = atan2(a.sin, a.cos);
    return select(angle < F(0.0f), angle + F(2.0f * kPi), angle);
  }
  /// Sine of the angle of `y` at a distance whose square is `squared`.
  static SHEAF_INLINE F sine(F y, F squared) { return y * inverse_sqrt<L>(squared + y * y); }

  F scale_, unit_;  ///< a power of two, and its inverse
  F x0_, x1_, y0_, y1_, h_;
  Angle left_;  ///< solid angle between the y axis and the side at x0, signed
  F solid_angle_;
};

}  // namespace sheaf

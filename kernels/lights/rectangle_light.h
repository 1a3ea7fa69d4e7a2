// Emissive rectangles. They are sampled by solid angle, and on surfaces approximately by solid angle times cosine: the
// cosines at the corners are interpolated (Hart et al., "Practical Product Sampling by Fitting and Composing Warps",
// 2020). Rectangles that look small are sampled uniformly by area.
#pragma once

#include "core/sampling/spherical_rectangle.h"
#include "kernels/lights/area_light.h"
#include "scene/lights/rectangle_light.h"

namespace sheaf {

/// A rectangle light as seen from a point.
template <class L> class VisibleRectangle {
  using F = Float<L>;

 public:
  /// `t`: its first vertex and its edges are a corner and the sides of the rectangle. `normal`: see LightQuery.
  SHEAF_INLINE VisibleRectangle(const LightTriangleRecord<L>& t, Vec3<L> from, Vec3<L> normal)
      : corner_(t.p - from),
        x_(t.edge1 * t.inverse_length1),
        y_(t.edge2 * t.inverse_length2),
        seen_(dot(corner_, x_), dot(corner_ + t.edge1, x_), dot(corner_, y_), dot(corner_ + t.edge2, y_),
              abs(dot(corner_, t.normal))) {
    constexpr float kMinSolidAngle = 3e-3f, kMinHeight = 16.0f;  // sr; ray offsets
    const F height = dot(corner_, t.normal);
    by_angle_ = (seen_.solid_angle() > F(kMinSolidAngle)) & (abs(height) > F(kMinHeight) * t.offset);
    // Corners below the horizon get a small weight, since the surface may transmit light
    constexpr float kMinWeight = 0.1f;
    const F along_z = dot(normal, t.normal) * copysign(F(1.0f), height);
    const CornerWeights<L> c = seen_.corner_cosines({dot(normal, x_), dot(normal, y_), along_z});
    const F largest = max(max(abs(c.w00), abs(c.w10)), max(abs(c.w01), abs(c.w11)));
    const F least = max(largest * F(kMinWeight), F(1e-6f));
    weights_ = {max(c.w00, least), max(c.w10, least), max(c.w01, least), max(c.w11, least)};
  }

  /// False if rounding would affect the solid angle, or if the point may lie on the rectangle itself.
  SHEAF_INLINE Mask<L> is_sampled_by_angle() const { return by_angle_; }
  /// A point sampled by angle, along the sides from the corner, m. `u`, `v`: uniform in [0, 1).
  SHEAF_INLINE Vec2<L> sample(F u, F v, F& pdf_solid_angle) const {
    const Vec2<L> at = square_to_bilinear<L>(weights_, u, v);
    pdf_solid_angle = bilinear_pdf<L>(weights_, at) / solid_angle();
    return seen_.sample(at.x, at.y);
  }
  /// Pdf of sample() for points in `direction`, at the distance `t`.
  SHEAF_INLINE F pdf_solid_angle(Vec3<L> direction, F t) const {
    const Vec3<L> at = direction * t - corner_;
    return bilinear_pdf<L>(weights_, seen_.invert({dot(at, x_), dot(at, y_)})) / solid_angle();
  }

 private:
  SHEAF_INLINE F solid_angle() const { return select(by_angle_, seen_.solid_angle(), F(1.0f)); }

  Vec3<L> corner_;  ///< from the point, m
  Vec3<L> x_, y_;   ///< unit vectors along the sides
  SphericalRectangle<L> seen_;
  Mask<L> by_angle_;
  CornerWeights<L> weights_;
};

struct RectangleLight {
  using Kind = RectangleLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kSurface;
  static constexpr bool kIsSampledInline = true;

  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>& texture) {
    const LightTriangleRecord<L> triangle = corner_triangle<L>(lights);
    const VisibleRectangle<L> rectangle(triangle, from, lights.normal);
    const auto by_angle = rectangle.is_sampled_by_angle();
    Float<L> pdf(0.0f);
    const Vec2<L> sampled = rectangle.sample(u.y, u.z, pdf);
    const Vec2<L> at{select(by_angle, sampled.x * triangle.inverse_length1, u.y),
                     select(by_angle, sampled.y * triangle.inverse_length2, u.z)};
    LightSample<L> s = sample_towards<L>(from, point<L>(lights, triangle, at, texture), lights.light);
    s.pdf_solid_angle = select(by_angle, pdf, s.pdf_solid_angle);
    return s;
  }

  template <class L> static SHEAF_INLINE Float<L> pdf_solid_angle(const LightQuery<L>& lights, const LightHit<L>& hit) {
    const VisibleRectangle<L> rectangle(corner_triangle<L>(lights), hit.from, lights.normal);
    return select(rectangle.is_sampled_by_angle(), rectangle.pdf_solid_angle(hit.direction, hit.t),
                  pdf_seen<L>(pdf_area<L>(lights), hit));
  }

  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>& texture) {
    return emit_from<L>(point<L>(lights, corner_triangle<L>(lights), {a.y, a.z}, texture), lights.light, b);
  }

 private:
  template <class L> static SHEAF_INLINE LightTriangleRecord<L> corner_triangle(const LightQuery<L>& lights) {
    const RectangleLightData<L> data = lights.light.template data<RectangleLightData>();
    return gather_rows<L>(lights.scene.lights.triangles, select(lights.active, data.mesh.first_triangle, Uint<L>(0u)));
  }

  template <class L> static SHEAF_INLINE Float<L> pdf_area(const LightQuery<L>& lights) {
    return Float<L>(1.0f) / lights.light.template data<RectangleLightData>().mesh.area;
  }

  /// The point at fractions of the sides.
  template <class L>
  static SHEAF_INLINE LightPoint<L> point(const LightQuery<L>& lights, const LightTriangleRecord<L>& triangle,
                                          Vec2<L> at, TextureQuery<L>& texture) {
    LightPoint<L> out;
    out.y.p = triangle.p + triangle.edge1 * at.x + triangle.edge2 * at.y;
    out.y.ng = triangle.normal;
    out.y.offset = triangle.offset;
    out.pdf_area = pdf_area<L>(lights);
    const auto textured = lights.active & lights.light.needs_texture_query();
    if (any(textured)) set_rectangle_query<L>(lights, textured, at, texture);
    return out;
  }

  /// The texture lookup for point(). Not inlined, because textured rectangles are rare.
  template <class L>
  [[gnu::noinline]] static void set_rectangle_query(const LightQuery<L>& lights, Mask<L> textured, Vec2<L> at,
                                                    TextureQuery<L>& texture) {
    using F = Float<L>;
    using U = Uint<L>;
    const RectangleLightData<L> data = lights.light.template data<RectangleLightData>();
    const F one(1.0f);
    // Compute barycentric coordinates in the triangle that contains the point, from its right angle on
    const auto second = at.x + at.y > one;
    const F b1 = select(second, one - at.x, at.x), b2 = select(second, one - at.y, at.y), b0 = one - b1 - b2;
    // Reorder them to those from the first vertex in the file on
    const U right_angle = select(second, data.right_angle1, data.right_angle0);
    const auto at1 = right_angle == U(1u), at2 = right_angle == U(2u);
    const F w0 = select(at1, b2, select(at2, b1, b0)), w1 = select(at1, b0, select(at2, b2, b1)), w2 = one - w0 - w1;
    const U index = select(second, U(1u), U(0u));
    const auto uvs = gather_rows<L>(lights.scene.lights.uvs, select(textured, data.mesh.first_uv + index, U(0u)));
    set_query<L>(textured, {uvs.at(w0, w1, w2), data.mesh.shape, index, w1, w2}, texture);
  }
};

template <> struct LightOf<RectangleLightKind> { using Type = RectangleLight; };

}  // namespace sheaf

// A measured BRDF in the parameterization of Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material
// Acquisition and Rendering" (ACM Transactions on Graphics 37, 2018), section 4. Half vectors are those of a microfacet
// model whose distribution of normals was fitted to the material. The values are tabulated over the random numbers that
// sample the visible normals of that model. A second table over these numbers, the luminance, makes samples follow the
// values. With m the half vector as a point (x, y) of the unit square (theta = pi x^2 / 2, phi = (2 y - 1) pi), D the
// distribution of normals, sigma the projected area and s the random numbers,
//   f cos(wi) = values(s) D(m) / (4 sigma(wo)),  pdf = luminance(s) vndf(m) / (2 pi^2 x sin(theta) 4 wo.m).
// wo is the incident direction of the measurement. The tables are used as measured, so f is only as reciprocal as the
// measurement.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/table_warp.h"
#include "scene/materials/measured.h"
#include "scene/tables/closure_tables.h"

namespace sheaf {

namespace measured_detail {

/// Spherical angles of a direction, and their mapping to [0, 1].
template <class L> struct Angles {
  Float<L> theta, phi;

  explicit SHEAF_INLINE Angles(Vec3<L> w) {
    using F = Float<L>;
    const F sine = sqrt(fma(w.x, w.x, w.y * w.y));
    theta = atan2(sine, w.z);
    phi = select(sine > F(0.0f), atan2(w.y, select(sine > F(0.0f), w.x, F(1.0f))), F(0.0f));
  }
  static SHEAF_INLINE Float<L> theta_to_unit(Float<L> theta) { return sqrt(max(theta, Float<L>(0.0f)) * (2 * kInvPi)); }
  static SHEAF_INLINE Float<L> phi_to_unit(Float<L> phi) { return fma(phi, Float<L>(0.5f * kInvPi), Float<L>(0.5f)); }
};

/// The tables of a material, for one outgoing direction per lane.
template <class L> class Table {
  using F = Float<L>;
  using U = Uint<L>;

 public:
  SHEAF_INLINE Table(const float* tables, Float<L> word, Vec3<L> wo)
      : tables_(tables), table_(find_table<L>(tables, word, TableTag::kMeasured)) {
    if (!any(table_.valid)) return;
    head_ = load_table_record<L, MeasuredHead>(tables, table_.first + U(1u));
    // The measured azimuths may cover only a half or a quarter of a turn, starting at -pi. Rotate or mirror the
    // directions into that range. A zero gets a sign too, which distinguishes -pi from pi.
    const auto symmetric = head_.reduction > F(1.5f);
    flip_y_ = select(symmetric, -copysign(F(1.0f), wo.y), F(1.0f));
    flip_x_ = select(head_.reduction > F(3.5f), -copysign(F(1.0f), wo.x), flip_y_);
    wo_ = flipped(wo);
    const Angles<L> angles(wo_);
    theta_ = angles.theta, phi_ = angles.phi;
  }

  /// Whether any lane has a table.
  SHEAF_INLINE bool any_valid() const { return any(table_.valid); }
  SHEAF_INLINE Vec3<L> flipped(Vec3<L> w) const { return {w.x * flip_x_, w.y * flip_y_, w.z}; }
  SHEAF_INLINE Vec3<L> wo() const { return wo_; }
  SHEAF_INLINE F phi() const { return phi_; }
  SHEAF_INLINE const MeasuredHead<L>& head() const { return head_; }

  SHEAF_INLINE SliceMix<L> slices() const {
    const U thetas = to_uint(head_.theta_count);
    return {find_neighbors<L>(tables_, block(head_.phi_block), to_uint(head_.phi_count), phi_),
            find_neighbors<L>(tables_, block(head_.theta_block), thetas, theta_), thetas};
  }
  SHEAF_INLINE TableWarp<L> vndf(const SliceMix<L>& mix) const {
    return {tables_, block(head_.vndf_block), to_uint(head_.vndf_width), to_uint(head_.vndf_height), mix};
  }
  SHEAF_INLINE TableWarp<L> luminance(const SliceMix<L>& mix) const {
    return {tables_, block(head_.luminance_block), to_uint(head_.sample_width), to_uint(head_.sample_height), mix};
  }
  SHEAF_INLINE U channels() const { return to_uint(head_.channels); }
  /// The values, one grid per channel, stored one after another.
  SHEAF_INLINE TableGrid<L> values(const SliceMix<L>& mix) const {
    const U width = to_uint(head_.sample_width), height = to_uint(head_.sample_height);
    return {tables_, block(head_.value_block), width * height * channels(), width, height, mix};
  }
  /// Factor D(m) / (4 sigma(wo)) on the values, for the half vector at (x, y) of the unit square.
  SHEAF_INLINE F scale(F x, F y) const {
    if (!any(head_.jacobian > F(0.0f))) return F(1.0f);
    const F normals = plain(head_.ndf_block, head_.ndf_width, head_.ndf_height, x, y);
    const F area = plain(head_.sigma_block, head_.sigma_width, head_.sigma_height, Angles<L>::theta_to_unit(theta_),
                         Angles<L>::phi_to_unit(phi_));
    return select(head_.jacobian > F(0.0f), normals / max(F(4.0f) * area, F(1e-12f)), F(1.0f));
  }

 private:
  SHEAF_INLINE U block(F number) const { return table_.first + (to_uint(number) << kTableBlockShift); }

  /// Bilinear lookup in a table that does not depend on wo.
  SHEAF_INLINE F plain(F block_number, F width, F height, F x, F y) const {
    const U w = to_uint(width), begin = block(block_number);
    const F position_x = clamp(x, F(0.0f), F(1.0f)) * (width - F(1.0f));
    const F position_y = clamp(y, F(0.0f), F(1.0f)) * (height - F(1.0f));
    const U column = min(to_uint(position_x), w - U(2u)), row = min(to_uint(position_y), to_uint(height) - U(2u));
    const U corner = begin + row * w + column;
    const F tx = position_x - to_float(column), ty = position_y - to_float(row);
    return lerp(ty, lerp(tx, gather(tables_, corner), gather(tables_, corner + U(1u))),
                lerp(tx, gather(tables_, corner + w), gather(tables_, corner + w + U(1u))));
  }

  const float* tables_;
  FoundTable<L> table_;
  MeasuredHead<L> head_{};
  Vec3<L> wo_{};
  F flip_x_{}, flip_y_{}, theta_{}, phi_{};
};

/// 2 pi^2 x sin(theta) 4 wo.m: solid angle of wi per area of the unit square of half vectors.
template <class L> SHEAF_INLINE Float<L> light_per_area(Float<L> x, Float<L> sin_theta, Float<L> cosine) {
  using F = Float<L>;
  return max(F(2.0f * kPi * kPi) * x * sin_theta, F(1e-6f)) * F(4.0f) * cosine;
}

/// f cos and pdf; bsdf.colors() interpolates the values.
template <class L, class Bsdf> SHEAF_INLINE BsdfValue<L> evaluate(const Bsdf& bsdf, Vec3<L> wo_in, Vec3<L> wi_in) {
  using F = Float<L>;
  const BsdfValue<L> black{Spectrum<L>(F(0.0f)), F(0.0f)};
  const auto above = (wo_in.z > F(0.0f)) & (wi_in.z > F(0.0f));
  if (!any(above)) return black;
  const Table<L> table(bsdf.tables, bsdf.table, wo_in);
  if (!table.any_valid()) return black;
  // Find the half vector as a point of the unit square.
  const Vec3<L> m = normalize(table.wo() + table.flipped(wi_in));
  const Angles<L> half(m);
  const F x = Angles<L>::theta_to_unit(half.theta);
  F y = Angles<L>::phi_to_unit(half.phi - select(table.head().isotropic > F(0.0f), table.phi(), F(0.0f)));
  y = y - floor(y);
  const SliceMix<L> mix = table.slices();
  // Invert the sampling of visible normals.
  const auto s = table.vndf(mix).invert(x, y);
  const F pdf = s.pdf * table.luminance(mix).pdf(s.x, s.y) /
                light_per_area<L>(x, sqrt(fma(m.x, m.x, m.y * m.y)), dot(table.wo(), m));
  const Spectrum<L> f_cos = bsdf.colors(table.values(mix), table.channels(), s.x, s.y) * table.scale(x, y);
  return {select<L>(above, f_cos, black.f_cos), select(above, pdf, F(0.0f))};
}

template <class L, class Bsdf> SHEAF_INLINE BsdfSample<L> sample(const Bsdf& bsdf, Vec3<L> wo_in, const Random4<L>& u) {
  using F = Float<L>;
  BsdfSample<L> out{wo_in, Spectrum<L>(F(0.0f)), F(0.0f), F(1.0f), Mask<L>(false)};
  const auto above = wo_in.z > F(0.0f);
  if (!any(above)) return out;
  const Table<L> table(bsdf.tables, bsdf.table, wo_in);
  if (!table.any_valid()) return out;
  const SliceMix<L> mix = table.slices();
  // Sample the luminance, then the visible normals.
  const auto s = table.luminance(mix).sample(u.y, u.z);
  const auto at = table.vndf(mix).sample(s.x, s.y);
  const F theta = F(0.5f * kPi) * at.x * at.x;
  const F sin_theta = sin(theta), cos_theta = cos(theta);
  // phi = (2 y - 1) pi, relative to the azimuth of wo if the material is isotropic.
  const auto azimuth = sincos_2pi<L>(at.y);
  Vec3<L> m{-azimuth.cos * sin_theta, -azimuth.sin * sin_theta, cos_theta};
  // Rotate isotropic materials by the azimuth of wo.
  const F length_xy = sqrt(fma(table.wo().x, table.wo().x, table.wo().y * table.wo().y));
  const auto rotated = (table.head().isotropic > F(0.0f)) & (length_xy > F(0.0f));
  const F c = select(rotated, table.wo().x / select(rotated, length_xy, F(1.0f)), F(1.0f));
  const F d = select(rotated, table.wo().y / select(rotated, length_xy, F(1.0f)), F(0.0f));
  m = {m.x * c - m.y * d, m.x * d + m.y * c, m.z};
  // Reflect wo, and compute pdf and weight.
  const F cosine = dot(table.wo(), m);
  const Vec3<L> wi = m * (F(2.0f) * cosine) - table.wo();
  out.pdf_solid_angle = s.pdf * at.pdf / light_per_area<L>(at.x, sin_theta, max(cosine, F(1e-6f)));
  out.wi = table.flipped(wi);
  out.valid = above & (cosine > F(0.0f)) & (wi.z > F(0.0f)) & (out.pdf_solid_angle > F(0.0f));
  const Spectrum<L> f_cos = bsdf.colors(table.values(mix), table.channels(), s.x, s.y) * table.scale(at.x, at.y);
  out.weight = select<L>(out.valid, f_cos * (F(1.0f) / select(out.valid, out.pdf_solid_angle, F(1.0f))), out.weight);
  return out;
}

}  // namespace measured_detail

/// With values for red, green and blue.
template <class L> struct MeasuredBsdf : MeasuredParameters<L> {
  using Closure = MeasuredClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  const float* tables = nullptr;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;
  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

  SHEAF_INLINE Spectrum<L> colors(const TableGrid<L>& values, Uint<L>, Float<L> x, Float<L> y) const {
    const TableCell<L> cell = values.cell(x, y);
    const Uint<L> size = values.width * values.height;
    return this->red * values.interpolate(cell, Uint<L>(0u)) + this->green * values.interpolate(cell, size) +
           this->blue * values.interpolate(cell, size + size);
  }
};

/// With values at many wavelengths, interpolated linearly.
template <class L> struct MeasuredSpectralBsdf : MeasuredSpectralParameters<L> {
  using Closure = MeasuredSpectralClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = true;
  const float* tables = nullptr;

  BsdfValue<L> evaluate(Vec3<L> wo, Vec3<L> wi) const;
  BsdfSample<L> sample(Vec3<L> wo, const Random4<L>& u) const;

  SHEAF_INLINE Spectrum<L> colors(const TableGrid<L>& values, Uint<L> channels, Float<L> x, Float<L> y) const {
    using F = Float<L>;
    using U = Uint<L>;
    const TableCell<L> cell = values.cell(x, y);
    const U size = values.width * values.height;
    return map_spectrum<L>(this->position, [&](F at) {
      const U low = min(to_uint(max(at, F(0.0f))), channels - U(1u));
      const U high = min(low + U(1u), channels - U(1u));
      return lerp(at - to_float(low), values.interpolate(cell, low * size), values.interpolate(cell, high * size));
    });
  }
};

template <> struct BsdfOf<MeasuredClosure> : BsdfTag<MeasuredBsdf> {};
template <> struct BsdfOf<MeasuredSpectralClosure> : BsdfTag<MeasuredSpectralBsdf> {};

}  // namespace sheaf

// An isotropic BRDF that is tabulated over half and difference angles (Rusinkiewicz, "A New Change of Variables for
// Efficient BRDF Representation", EGWR 1998). With h the half vector, n the normal, b along n x h and t = b x h:
// theta_h is the angle between n and h, theta_d that between h and the direction to the light, phi_d the azimuth of the
// latter around h, from t towards b. Values are interpolated linearly. Samples follow a mixture of a GGX distribution
// of visible normals and a cosine lobe, independent of the values.
#pragma once

#include "core/sampling/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "kernels/bsdf/microfacet.h"
#include "kernels/bsdf/table_warp.h"
#include "scene/tables/closure_tables.h"

namespace sheaf::half_angle_detail {

/// Probability of the cosine lobe.
inline constexpr float kCosineLobe = 0.1f;

/// Lanes whose word refers to such a table.
template <class L> SHEAF_INLINE Mask<L> has_table(const float* tables, Float<L> word) {
  using F = Float<L>;
  const auto inside = (word >= F(0.0f)) & (word < F(tables[0]));
  const Uint<L> first = to_uint(select(inside, word, F(0.0f))) << kTableBlockShift;
  return float_bits(gather(tables, first)) == Uint<L>(static_cast<std::uint32_t>(TableTag::kHalfAngle));
}

/// The table of each lane. At least one lane must have one.
template <class L> class Table {
  using F = Float<L>;
  using U = Uint<L>;

 public:
  SHEAF_INLINE Table(const float* tables, F word)
      : tables_(tables),
        first_(find_table<L>(tables, word, TableTag::kHalfAngle).first),
        head_(load_table_record<L, HalfAngleHead>(tables, first_ + U(1u))) {}

  /// f cos and pdf, for directions above the surface; bsdf.colors() interpolates the values.
  template <class Bsdf> SHEAF_INLINE BsdfValue<L> evaluate(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) const {
    const Vec3<L> h = normalize(wo + wi);
    // Angles; b and t have the length sin(theta_h), and any azimuth serves where that is 0
    const F sine2 = fma(h.x, h.x, h.y * h.y), b_wi = h.x * wi.y - h.y * wi.x;
    const F t_wi = fma(h.z, fma(h.x, wi.x, h.y * wi.y), -sine2 * wi.z);
    const auto has_azimuth = abs(b_wi) + abs(t_wi) > F(0.0f);
    const F phi_d = select(has_azimuth, atan2(b_wi, select(has_azimuth, t_wi, F(1.0f))), F(0.0f));
    const F theta_h = atan2(sqrt(sine2), h.z);
    const Vec3<L> across = wi - wo;
    const F theta_d = atan2(length(across), length(wo + wi));
    // Interpolate the values
    const U height = to_uint(head_.theta_d_count), width = to_uint(head_.theta_h_count),
            channels = to_uint(head_.channels);
    const Neighbors<L> row = neighbors(head_.theta_d_block, height, theta_d),
                       column = neighbors(head_.theta_h_block, width, theta_h);
    const SliceMix<L> mix(neighbors(head_.phi_block, to_uint(head_.phi_count), phi_d), {U(0u), U(0u), F(0.0f)}, U(1u));
    const TableGrid<L> values{tables_, block(head_.value_block), width * height * channels, width, height, mix};
    const Spectrum<L> f = bsdf.colors(values, channels, in_unit(column, width), in_unit(row, height));
    return {f * wi.z, pdf(wo, wi, h)};
  }

  template <class Bsdf> SHEAF_INLINE BsdfSample<L> sample(const Bsdf& bsdf, Vec3<L> wo, const Random4<L>& u) const {
    const auto is_cosine = u.x < F(kCosineLobe);
    const Vec3<L> m = normals().sample_visible(wo, u.y, u.z);
    const Vec3<L> wi = select<L>(is_cosine, square_to_cosine_hemisphere<L>(u.y, u.z), m * (F(2.0f) * dot(wo, m)) - wo);
    const BsdfValue<L> value = evaluate(bsdf, wo, wi);
    const Mask<L> valid = (wo.z > F(0.0f)) & (wi.z > F(0.0f)) & (value.pdf_solid_angle > F(0.0f));
    const F pdf = select(valid, value.pdf_solid_angle, F(1.0f));
    const Spectrum<L> black(F(0.0f));
    return {wi, select<L>(valid, value.f_cos * (F(1.0f) / pdf), black), select(valid, pdf, F(0.0f)), F(1.0f), valid};
  }

 private:
  SHEAF_INLINE U block(F number) const { return first_ + (to_uint(number) << kTableBlockShift); }
  SHEAF_INLINE Neighbors<L> neighbors(F block_number, U count, F angle) const {
    return find_neighbors<L>(tables_, block(block_number), count, angle);
  }
  /// Position in the unit interval of a grid with equal distances.
  static SHEAF_INLINE F in_unit(const Neighbors<L>& at, U count) {
    return (to_float(at.low) + at.t) / to_float(count - U(1u));
  }
  SHEAF_INLINE GgxDistribution<L> normals() const { return {head_.alpha, head_.alpha}; }
  SHEAF_INLINE F pdf(Vec3<L> wo, Vec3<L> wi, Vec3<L> h) const {
    const F facets = normals().pdf_visible(wo, h) / max(F(4.0f) * dot(wo, h), F(1e-12f));
    return F(kCosineLobe) * cosine_hemisphere_pdf_solid_angle(wi.z) + F(1.0f - kCosineLobe) * facets;
  }

  const float* tables_;
  U first_;
  HalfAngleHead<L> head_;
};

template <class L, class Bsdf> SHEAF_INLINE BsdfValue<L> evaluate(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  const auto above = (wo.z > Float<L>(0.0f)) & (wi.z > Float<L>(0.0f));
  const Spectrum<L> black(Float<L>(0.0f));
  const BsdfValue<L> value = Table<L>(bsdf.tables, bsdf.table).evaluate(bsdf, wo, wi);
  return {select<L>(above, value.f_cos, black), select(above, value.pdf_solid_angle, Float<L>(0.0f))};
}

template <class L, class Bsdf> SHEAF_INLINE BsdfSample<L> sample(const Bsdf& bsdf, Vec3<L> wo, const Random4<L>& u) {
  return Table<L>(bsdf.tables, bsdf.table).sample(bsdf, wo, u);
}

}  // namespace sheaf::half_angle_detail

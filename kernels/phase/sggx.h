// The phase function of microflakes that mirror, whose normals follow the SGGX distribution (Heitz, Dupuy, Crassin and
// Dachsbacher 2015, "The SGGX Microflake Distribution"): of a symmetric positive matrix S,
//   D(h) = 1 / (pi sqrt(det S) (h^T S^-1 h)^2),  sigma(w) = sqrt(w^T S w),  p(wo, wi) = D(h) / (4 sigma(wo)),
// h halfway between wo and wi. sigma, the flakes' projected area, is a factor on the medium's extinction (MediumRay).
//
// Here z is wo, and S = M M^T with M upper triangular, whose lower right corner then is sigma(wo): h^T S^-1 h is the
// square of M^-1 h, by substitution; and a normal that is seen from wo is M y over its length, y spread over the
// hemisphere as its projection over the disk (section 4.2). Nothing is subtracted that is nearly the same, as by way of
// the determinant of matrices of thin fibres.
#pragma once

#include "core/frame.h"
#include "core/warp.h"
#include "kernels/bsdf/bsdf.h"
#include "scene/tables/material.h"

namespace sheaf {

template <class L> struct SggxBsdf : SggxParameters<L> {
  static constexpr auto kKind = ClosureKind::kSggx;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L> wi) const {
    using F = Float<L>;
    Vec3<L> h{wi.x, wi.y, F(1.0f) + wi.z};
    // Straight on: the flakes that light grazes, whichever.
    const auto grazed = !(dot(h, h) > F(1e-12f));
    h = select<L>(grazed, {F(1.0f), F(0.0f), F(0.0f)}, h);
    const F c = h.z / this->zz, b = (h.y - this->yz * c) / this->yy, a = (h.x - this->xy * b - this->xz * c) / this->xx;
    const F pdf = density(dot(h, h) / (a * a + b * b + c * c));
    return {Spectrum<L>(pdf), pdf};
  }

  SHEAF_INLINE BsdfSample<L> sample(Vec3<L>, const Random4<L>& u) const {
    using F = Float<L>;
    const Vec2<L> d = square_to_disk<L>(u.y, u.z);
    const F c = safe_sqrt(F(1.0f) - d.x * d.x - d.y * d.y);
    const Vec3<L> h{this->xx * d.x + this->xy * d.y + this->xz * c, this->yy * d.y + this->yz * c, this->zz * c};
    const F squared = dot(h, h), twice = F(2.0f) * h.z / squared;
    BsdfSample<L> s;
    s.wi = normalize(Vec3<L>{twice * h.x, twice * h.y, twice * h.z - F(1.0f)});
    s.weight = Spectrum<L>(F(1.0f));
    s.pdf_solid_angle = density(squared);
    s.eta_scale = F(1.0f);
    s.valid = (s.pdf_solid_angle > F(0.0f)) & is_finite(s.pdf_solid_angle);
    return s;
  }

 private:
  /// Where h^T S^-1 h is 1 / `inverse`, h of unit length.
  SHEAF_INLINE Float<L> density(Float<L> inverse) const {
    return Float<L>(0.25f * kInvPi) * inverse * inverse / (this->xx * this->yy * this->zz * this->zz);
  }
};

/// The parameters that stand for the matrix of xx, yy, zz, xy, xz, yz in world space, at a vertex whose frame is
/// `frame`. The phase function does not depend on the matrix' size, which becomes 1. Flakes that are all but parallel
/// to a line or a plane are spread a little, by 1/1000 of that.
template <class L> SHEAF_INLINE SggxParameters<L> sggx_parameters(const Float<L> (&s)[6], const Frame<L>& frame) {
  using F = Float<L>;
  const auto times = [&s](Vec3<L> v) SHEAF_LAMBDA_INLINE {
    return Vec3<L>{s[0] * v.x + s[3] * v.y + s[4] * v.z, s[3] * v.x + s[1] * v.y + s[5] * v.z,
                   s[4] * v.x + s[5] * v.y + s[2] * v.z};
  };
  const Vec3<L> sx = times(frame.s), sy = times(frame.t), sz = times(frame.n);
  const F size = F(1.0f) / max(s[0] + s[1] + s[2], F(1e-30f)), least(1e-6f);
  SggxParameters<L> p;
  p.zz = sqrt(max(size * dot(frame.n, sz), least));
  p.xz = size * dot(frame.s, sz) / p.zz;
  p.yz = size * dot(frame.t, sz) / p.zz;
  p.yy = sqrt(max(size * dot(frame.t, sy) - p.yz * p.yz, least));
  p.xy = (size * dot(frame.t, sx) - p.xz * p.yz) / p.yy;
  p.xx = sqrt(max(size * dot(frame.s, sx) - p.xy * p.xy - p.xz * p.xz, least));
  return p;
}

}  // namespace sheaf

// The phase function of specular microflakes with the SGGX distribution of normals (Heitz, Dupuy, Crassin and
// Dachsbacher 2015, "The SGGX Microflake Distribution"). For a symmetric positive matrix S,
//   D(h) = 1 / (pi sqrt(det S) (h^T S^-1 h)^2),  sigma(w) = sqrt(w^T S w),  p(wo, wi) = D(h) / (4 sigma(wo)),
// where h is the half vector. sigma, the projected area of the flakes, scales the medium's extinction (MediumRay).
//
// In the local frame z is wo, and S = M M^T with M upper triangular, so the lower right element of M is sigma(wo). h^T
// S^-1 h is the squared length of M^-1 h, found by substitution. A visible normal is M y, normalized, where y is
// distributed over the hemisphere so that its projection onto the disk is uniform (section 4.2). Unlike the
// determinant, this involves no cancellation for the matrices of thin fibers.
#pragma once

#include "core/math/frame.h"
#include "core/sampling/warp.h"
#include "kernels/phase/phase_function.h"
#include "scene/materials/phase_functions.h"

namespace sheaf {

template <class L> struct SggxBsdf : SggxParameters<L> {
  using Closure = SggxClosure;
  static constexpr bool kIsSpecular = false, kIsAnisotropic = false;

  SHEAF_INLINE BsdfValue<L> evaluate(Vec3<L>, Vec3<L> wi) const {
    using F = Float<L>;
    Vec3<L> h{wi.x, wi.y, F(1.0f) + wi.z};
    // Straight transmission: any flake at grazing incidence will do.
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
  /// `inverse` is 1 / (h^T S^-1 h) for unit h.
  SHEAF_INLINE Float<L> density(Float<L> inverse) const {
    return Float<L>(0.25f * kInvPi) * inverse * inverse / (this->xx * this->yy * this->zz * this->zz);
  }
};

/// The local parameters for the world-space matrix (xx, yy, zz, xy, xz, yz) at a vertex with the frame `frame`. The
/// phase function does not depend on the scale of the matrix, which is normalized to a trace of 1. Flakes that are
/// almost perfectly aligned to a line or plane are spread by 1/1000 of that scale.
template <class L> SHEAF_INLINE SggxParameters<L> sggx_parameters(const Float<L> (&s)[6], const Frame<L>& frame) {
  using F = Float<L>;
  const auto times = [&s](Vec3<L> v) SHEAF_LAMBDA_INLINE {
    return Vec3<L>{s[0] * v.x + s[3] * v.y + s[4] * v.z, s[3] * v.x + s[1] * v.y + s[5] * v.z,
                   s[4] * v.x + s[5] * v.y + s[2] * v.z};
  };
  const Vec3<L> sx = times(frame.s), sy = times(frame.t), sz = times(frame.n);
  const F size = F(1.0f) / max(s[0] + s[1] + s[2], F(1e-30f)), epsilon(1e-6f);
  SggxParameters<L> p;
  p.zz = sqrt(max(size * dot(frame.n, sz), epsilon));
  p.xz = size * dot(frame.s, sz) / p.zz;
  p.yz = size * dot(frame.t, sz) / p.zz;
  p.yy = sqrt(max(size * dot(frame.t, sy) - p.yz * p.yz, epsilon));
  p.xy = (size * dot(frame.t, sx) - p.xz * p.yz) / p.yy;
  p.xx = sqrt(max(size * dot(frame.s, sx) - p.xy * p.xy - p.xz * p.xz, epsilon));
  return p;
}

template <> struct BsdfOf<SggxClosure> : BsdfTag<SggxBsdf> {};

}  // namespace sheaf

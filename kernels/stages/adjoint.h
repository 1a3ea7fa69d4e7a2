// Adjoint BSDFs: how photons are scattered (Veach 1997, sections 5.2 and 5.3). BSDFs are written for radiance: wo
// points to the camera, and light arrives from wi. A photon arrives from wo and leaves along wi.
#pragma once

#include "core/color/spectrum.h"
#include "kernels/stages/normal_map.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// Factor for photons on f times the cosine to the shading normal (Veach 1997, section 5.3, equation 5.20). The cosine
/// of the shading normal belongs to the direction that light arrives from, and photons hit the geometric surface.
/// `arriving` (to where the photon came from) and `leaving`: world space. `cos_wi`: cosine of `leaving` to the shading
/// normal.
template <class L>
SHEAF_INLINE Float<L> adjoint_cosines(const VertexItem<L>& item, Vec3<L> arriving, Vec3<L> leaving, Float<L> cos_wi) {
  using F = Float<L>;
  const F above = abs(item.wo.z * dot(leaving, item.ng)), below = abs(dot(arriving, item.ng) * cos_wi);
  return above / max(below, F(1e-20f));
}

/// Probability of choosing the mirror image of a mapped normal. Mapped normals that face away from the viewer are
/// mirrored, but the direction in which a photon leaves is not known when the normal is chosen. So one of the two
/// normals is chosen at random, and photons that leave to the side that sees the other one are terminated.
/// TexturedItem::normal_choice: 1 the normal, -1 its mirror image, 0 no choice.
template <class F> SHEAF_INLINE F mirrored_probability(F cos_tilt) {
  // Approximates the fraction of directions above the unmapped normal from which the mapped one faces away.
  return min(F(0.64f) * sqrt(max(F(0.5f) - F(0.5f) * cos_tilt, F(0.0f))), F(0.5f));
}

/// Whether a photon that leaves along `leaving` sees the normal that was chosen.
template <class L> SHEAF_INLINE Mask<L> matches_normal_choice(const TexturedItem<L>& t, Vec3<L> ns, Vec3<L> leaving) {
  using F = Float<L>;
  const auto mirrored = t.normal_choice < F(0.0f);
  const Vec3<L> n = select<L>(mirrored, mirrored_normal<L>(ns, t.ns_unmapped), ns);
  const auto away = faces_away<L>(n, t.ns_unmapped, leaving);
  return (t.normal_choice == F(0.0f)) | ((mirrored & away) | ((!mirrored) & (!away)));
}

/// shadow_terminator() for the direction that light arrives from, which is the photon's own.
template <class L>
SHEAF_INLINE Float<L> adjoint_terminator(const TexturedItem<L>& t, Vec3<L> arriving, Float<L> cos_wo) {
  return shadow_terminator<L>(t.ns_unmapped, t.terminator, arriving, cos_wo);
}

/// Whether the BSDF is not reciprocal even without refraction.
template <class Bsdf, class V>
concept NotReciprocal = requires(const Bsdf& bsdf, V w) {
  bsdf.adjoint_f_cos(w, w);
};

/// f times |cos(wi)| for a photon that arrives from wo and leaves along wi.
template <class L, class Bsdf> SHEAF_INLINE Spectrum<L> adjoint_f_cos(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  if constexpr (NotReciprocal<Bsdf, Vec3<L>>)
    return bsdf.adjoint_f_cos(wo, wi);
  else
    return bsdf.evaluate(wo, wi).f_cos;
}

/// Removes the factor 1 / eta^2 from evaluate(): refraction scales radiance by it, but not the flux of photons (Veach
/// 1997, section 5.2).
template <class L, class Bsdf> SHEAF_INLINE Float<L> adjoint_scale(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  using F = Float<L>;
  if constexpr (requires { bsdf.squared_index(wo); })
    return select(wo.z * wi.z < F(0.0f), bsdf.squared_index(wo), F(1.0f));
  return F(1.0f);
}

}  // namespace sheaf

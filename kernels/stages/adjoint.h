// What a BSDF does to photons where it isn't what it does to paths from the camera. BSDFs are written for radiance: wo
// is where the camera is, wi where light comes from. A photon comes from wo and leaves along wi.
#pragma once

#include "core/spectrum.h"
#include "kernels/stages/normal_map.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// By what to multiply f times the cosine to the shading normal for photons (Veach 1997, section 5.3, equation 5.20):
/// the shading normal's cosine belongs to where light comes from, and the surface that a photon meets is the geometric
/// one. `leaving`: world space; `wi` the same in the shading frame. `item`: with wo, where the photon comes from.
template <class L>
SHEAF_INLINE Float<L> adjoint_cosines(const VertexItem<L>& item, Vec3<L> arriving, Vec3<L> leaving, Float<L> cos_wi) {
  using F = Float<L>;
  const F above = abs(item.wo.z * dot(leaving, item.ng)), below = abs(dot(arriving, item.ng) * cos_wi);
  return above / max(below, F(1e-20f));
}

/// Normals that face away from the viewer are mirrored, and of a photon the viewer is where it goes, not where it comes
/// from. So one of both normals is chosen before that is known, and a photon that then goes where the other one is seen
/// ends. TexturedItem::normal_choice says which: 1 the normal as it is, -1 its mirror image, 0 there is no choice. Its
/// probability:
template <class F> SHEAF_INLINE F mirrored_probability(F cos_turn) {
  // About the part of the directions around the unturned normal from which the turned one is seen from behind.
  return min(F(0.64f) * sqrt(max(F(0.5f) - F(0.5f) * cos_turn, F(0.0f))), F(0.5f));
}

/// Whether a photon that leaves in direction `leaving` is seen with the normal that was chosen.
template <class L> SHEAF_INLINE Mask<L> matches_normal_choice(const TexturedItem<L>& t, Vec3<L> ns, Vec3<L> leaving) {
  using F = Float<L>;
  const auto mirrored = t.normal_choice < F(0.0f);
  const Vec3<L> n = select<L>(mirrored, mirrored_normal<L>(ns, t.ns_unmapped), ns);
  const auto away = faces_away<L>(n, t.ns_unmapped, leaving);
  return (t.normal_choice == F(0.0f)) | ((mirrored & away) | ((!mirrored) & (!away)));
}

/// shadow_terminator() of the direction that light comes from, which is the photon's own.
template <class L>
SHEAF_INLINE Float<L> adjoint_terminator(const TexturedItem<L>& t, Vec3<L> arriving, Float<L> cos_wo) {
  return shadow_terminator<L>(t.ns_unmapped, t.terminator, arriving, cos_wo);
}

/// Whether photons are not scattered as paths are, even without refraction.
template <class Bsdf, class V>
concept NotReciprocal = requires(const Bsdf& bsdf, V w) {
  bsdf.adjoint_f_cos(w, w);
};

/// f times |cos(wi)| for a photon that comes from wo and leaves along wi.
template <class L, class Bsdf> SHEAF_INLINE Spectrum<L> adjoint_f_cos(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  if constexpr (NotReciprocal<Bsdf, Vec3<L>>)
    return bsdf.adjoint_f_cos(wo, wi);
  else
    return bsdf.evaluate(wo, wi).f_cos;
}

/// Radiance is scaled by 1 / eta^2 where it enters a medium, photons are not (Veach 1997, section 5.2): the factor that
/// takes it out of evaluate().
template <class L, class Bsdf> SHEAF_INLINE Float<L> adjoint_scale(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  using F = Float<L>;
  if constexpr (requires { bsdf.squared_index(wo); })
    return select(wo.z * wi.z < F(0.0f), bsdf.squared_index(wo), F(1.0f));
  return F(1.0f);
}

}  // namespace sheaf

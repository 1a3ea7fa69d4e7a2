// Normal and bump maps: how a texture perturbs the shading normal, and corrections of the artifacts of perturbed
// normals.
#pragma once

#include "kernels/stages/shading_frame.h"
#include "scene/textures/texture_lookup.h"

namespace sheaf {

/// Fraction of the light from `wi` that the shadow terminator of a mapped normal keeps. It is 0 where the mapped and
/// the unmapped normal disagree on the side of `wi`; `cos_wi` is the cosine to the mapped one. It falls off smoothly
/// where `wi` is near the horizon of the unmapped normal. The fall-off is the shadowing function of a microfacet
/// surface of squared roughness `terminator` (Estevez, Lecocq and Stein 2019, "A Microfacet-Based Shadowing Function to
/// Solve the Bump Terminator Problem").
template <class L>
SHEAF_INLINE Float<L> shadow_terminator(Vec3<L> ns_unmapped, Float<L> terminator, Vec3<L> wi, Float<L> cos_wi) {
  using F = Float<L>;
  const F cos_unmapped = dot(ns_unmapped, wi);
  const F cos2 = max(cos_unmapped * cos_unmapped, F(1e-12f));
  const F tan2 = max(F(1.0f) - cos2, F(0.0f)) / cos2;
  const F g = F(2.0f) / (F(1.0f) + sqrt(F(1.0f) + terminator * tan2));
  return select(cos_unmapped * cos_wi > F(0.0f), g, F(0.0f));
}

/// Squared roughness for shadow_terminator(). `cos_tilt`: cosine between the mapped and the unmapped normal.
template <class F> SHEAF_INLINE F terminator_of(F cos_tilt) {
  const F cos2 = max(min(cos_tilt * cos_tilt, F(1.0f)), F(1e-12f));
  return clamp(F(0.125f) * (F(1.0f) - cos2) / cos2, F(0.0f), F(1.0f));
}

/// The normal of a normal map, in the unmapped shading frame, unnormalized.
template <class L>
SHEAF_INLINE Vec3<L> mapped_normal(const TextureView& textures, const NormalMapRow& map, const TextureQuery<L>& query) {
  using F = Float<L>;
  const Spectrum<L> rgb = lookup_texture<L>(textures, map.texture, query);
  const F x = F(2.0f) * rgb.c0 - F(1.0f), y = F(2.0f) * rgb.c1 - F(1.0f), scale(map.scale);
  return {scale * x, scale * (map.flags & NormalMapRow::kFlipGreen ? -y : y), F(2.0f) * rgb.c2 - F(1.0f)};
}

/// The normal of the surface displaced by a bump map, in world space, unnormalized. Ignores the change of the unmapped
/// normal over the surface (Blinn 1978).
template <class L>
SHEAF_INLINE Vec3<L> bumped_normal(const TextureView& textures, const NormalMapRow& map, const TextureQuery<L>& query,
                                   Vec3<L> n, Vec3<L> dp_du, Vec3<L> dp_dv) {
  using F = Float<L>;
  const Vec2<L> gradient = lookup_scalar_gradient<L>(textures, map.texture, query);
  const Vec3<L> along_u = dp_du + n * (F(map.scale) * gradient.x - dot(n, dp_du));
  const Vec3<L> along_v = dp_dv + n * (F(map.scale) * gradient.y - dot(n, dp_dv));
  return cross(along_u, along_v);
}

/// The mapped shading normal, unit length. `base`: unmapped shading normal, facing the viewer for two-sided materials.
/// `handedness`: -1 if it was flipped, otherwise 1. Sets `usable` to the lanes of `lanes` where the map gives a normal,
/// and returns `base` in the others.
template <class L>
SHEAF_INLINE Vec3<L> perturbed_normal(const TextureView& textures, const NormalMapRow& map,
                                      const TextureQuery<L>& query, Vec3<L> base, Float<L> handedness, Vec3<L> dp_du,
                                      Vec3<L> dp_dv, Mask<L> lanes, Mask<L>& usable) {
  using F = Float<L>;
  const Frame<L> frame = Frame<L>::from_normal(base);
  const Vec2<L> c = tangent_of<L>(frame, dp_du);
  const Vec3<L> s = frame.s * c.x + frame.t * c.y;
  Vec3<L> bitangent = cross(base, s) * handedness;
  if (map.flags & NormalMapRow::kFollowsUv)
    bitangent = select<L>(dot(bitangent, dp_dv) < F(0.0f), -bitangent, bitangent);
  Vec3<L> n;
  if (map.flags & NormalMapRow::kBump) {
    // Seen from behind, the displaced surface is the mirror image of its front, as normal maps are.
    const Vec3<L> outward = base * handedness;
    n = bumped_normal<L>(textures, map, query, outward, dp_du, dp_dv);
    n = n * copysign(F(1.0f), dot(n, outward));
    n = select<L>(handedness < F(0.0f), n - outward * (F(2.0f) * dot(n, outward)), n);
  } else {
    const Vec3<L> local = mapped_normal<L>(textures, map, query);
    n = s * local.x + bitangent * local.y + base * local.z;
  }
  const F squared = dot(n, n);
  usable = lanes & (squared > F(1e-20f)) & is_finite(squared);
  return select<L>(usable, n * (F(1.0f) / sqrt(select(usable, squared, F(1.0f)))), base);
}

/// Mirrors a mapped normal at the unmapped one, to replace it where it faces away from the viewer.
template <class L> SHEAF_INLINE Vec3<L> mirrored_normal(Vec3<L> n, Vec3<L> unmapped) {
  return unmapped * (Float<L>(2.0f) * dot(unmapped, n)) - n;
}

/// Whether direction `wo` sees the mapped and the unmapped normal from different sides.
template <class L> SHEAF_INLINE Mask<L> faces_away(Vec3<L> n, Vec3<L> unmapped, Vec3<L> wo) {
  return dot(n, wo) * dot(unmapped, wo) < Float<L>(0.0f);
}

}  // namespace sheaf

// Clearcoats over the emission of area lights (KHR_materials_clearcoat): they attenuate the radiance in a direction by
// 1 - strength F, where F is the coat's reflectance for the angle to the geometric normal.
#pragma once

#include "core/soa/lane_array.h"
#include "kernels/bsdf/principled_lobes.h"
#include "scene/tables/scene_view.h"
#include "scene/textures/texture_lookup.h"

namespace sheaf {

/// Transmittance of the coats over area lights in directions with these cosines to their normals, on either side; 1 for
/// lights without a coat. Lanes of a register may have different coats. Requires LightView::coats.
template <class L>
[[gnu::noinline]] Float<L> coat_transmittance(const SceneView& scene, const LightRecord<L>& light, Mask<L> active,
                                              Float<L> cosine, const TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  const F zero(0.0f), one(1.0f), reflectance = Clearcoat<L>::fresnel(schlick_weight(min(abs(cosine), one)));
  const U coat = light.flags >> kLightCoatShift;
  F out = one;
  const LaneArray<U> lanes(coat);
  for (std::uint32_t left = mask_bits(active & (coat != U(0u))); left != 0;) {
    const std::uint32_t number = lanes[std::countr_zero(left)];
    const LightCoatRow& row = scene.lights.coats[number - 1];
    F strength(row.strength);
    if (row.texture != kNone) strength = lookup_scalar<L>(scene.textures, row.texture, query);
    const auto same = coat == U(number);
    out = select(same, one - clamp(strength, zero, one) * reflectance, out);
    left &= ~mask_bits(same);
  }
  return out;
}

}  // namespace sheaf

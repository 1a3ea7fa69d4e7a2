// Which light: one interface for surfaces, media and photons, whatever the selector.
#pragma once

#include "core/distribution.h"
#include "core/groups.h"
#include "scene/scene.h"

namespace sheaf {

/// A light and the probability with which it was chosen.
template <class L> struct LightChoice {
  typename L::Uint light;         ///< row of SceneView::lights; 0 where the probability is 0
  typename L::Float probability;  ///< 0: no light can reach the point
};

/// Where light is wanted. `n` is the shading normal of a surface, and zero in media, where light counts from all sides.
template <class L> struct LightReceiver {
  Vec3<L> p, n;
};

/// Chooses a light by u in [0, 1), as SceneView::light_selector says. The scene must have lights.
template <class L>
SHEAF_INLINE LightChoice<L> choose_light(const SceneView& scene, const LightReceiver<L>&, typename L::Float u) {
  using F = typename L::Float;
  using U = typename L::Uint;
  if (scene.light_count == 1) return {U(0u), F(1.0f)};
  if (scene.integrator.light_selector == LightSelector::kUniform) {
    const auto count = static_cast<float>(scene.light_count);
    return {min(to_uint(u * F(count)), U(scene.light_count - 1)), F(1.0f / count)};
  }
  const auto entry = sample_alias<L>(scene.light_alias, U(0u), U(scene.light_count), u);
  return {entry.index, entry.pdf};
}

/// The probability with which choose_light finds `light`.
template <class L>
SHEAF_INLINE Float<L> choice_probability(const SceneView& scene, const LightReceiver<L>&, typename L::Uint light) {
  using F = typename L::Float;
  if (scene.light_count == 1) return F(1.0f);
  if (scene.integrator.light_selector == LightSelector::kUniform) return F(1.0f / static_cast<float>(scene.light_count));
  F entry[4];
  gather_row4<L>(reinterpret_cast<const float*>(scene.light_alias), light << 2, entry);
  return entry[2];
}

}  // namespace sheaf

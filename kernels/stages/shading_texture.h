// What a texture puts in place of a closure's words.
#pragma once

#include "scene/tables/scene.h"
#include "scene/tables/texture_lookup.h"

namespace sheaf {

/// A looked-up colour at the path's wavelengths, by the spectrum that its texture's values stand for.
template <class L>
SHEAF_INLINE Spectrum<L> uplifted(const SceneView& scene, TextureRole role, const Spectrum<L>& rgb,
                                  const Spectrum<L>& lambda) {
  const Vec3<L> color{rgb.c0, rgb.c1, rgb.c2};
  const UpliftTable& table = *scene.spectral.uplift;
  const bool reflectance = role == TextureRole::kReflectance;
  return evaluate(reflectance ? uplift_reflectance<L>(table, color) : uplift_unbounded<L>(table, color), lambda);
}

/// binding.words values, from the first lane on; in spectral mode colours are taken to the wavelengths `lambda`.
template <class L, ColorMode Mode>
SHEAF_INLINE Spectrum<L> shading_texture(const SceneView& scene, const TextureBinding& binding,
                                         const TextureQuery<L>& query, const Spectrum<L>& lambda) {
  const Spectrum<L> value = lookup_binding<L>(scene.textures, binding, query);
  if constexpr (Mode == ColorMode::kSpectral)
    if (binding.words == 4) return uplifted<L>(scene, binding.role, value, lambda);
  return value;
}

}  // namespace sheaf

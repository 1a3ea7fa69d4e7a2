// Texture lookups for the parameters of closures.
#pragma once

#include "scene/tables/scene_view.h"
#include "scene/textures/texture_lookup.h"

namespace sheaf {

/// Upsamples a looked-up color to the wavelengths `lambda`, nm (Jakob and Hanika 2019). `role`: reflectances stay in
/// [0, 1], other spectra are unbounded.
template <class L>
SHEAF_INLINE Spectrum<L> uplifted(const SceneView& scene, TextureRole role, const Spectrum<L>& rgb,
                                  const Spectrum<L>& lambda) {
  const Vec3<L> color{rgb.c0, rgb.c1, rgb.c2};
  const UpliftTable& table = *scene.spectral.uplift;
  const bool reflectance = role == TextureRole::kReflectance;
  return evaluate(reflectance ? uplift_reflectance<L>(table, color) : uplift_unbounded<L>(table, color), lambda);
}

/// The `binding.words` values of a texture, in the first lanes of the result. Spectral mode: colors are upsampled to
/// the wavelengths `lambda`, nm.
template <class L, ColorMode kMode>
SHEAF_INLINE Spectrum<L> shading_texture(const SceneView& scene, const TextureBinding& binding,
                                         const TextureQuery<L>& query, const Spectrum<L>& lambda) {
  const Spectrum<L> value = lookup_binding<L>(scene.textures, binding, query);
  if constexpr (kMode == ColorMode::kSpectral)
    if (binding.words == 4) return uplifted<L>(scene, binding.role, value, lambda);
  return value;
}

}  // namespace sheaf

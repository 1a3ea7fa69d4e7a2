// Scene data for placing lights.
#pragma once

#include "scene/lights/list.h"
#include "scene/tables/envmap.h"
#include "scene/tables/texture.h"

namespace sheaf {

class SpectrumSet;
struct IntegratorSettings;

/// The emission of a light in both colour modes.
struct LightEmission {
  Vec3f rgb;             ///< linear Rec.709, RGB mode; 1 for textures
  SpectrumRow spectrum;  ///< spectral mode; relative to D65 for textures
};

/// Makes a row without texture.
LightRow make_light_row(LightKind kind, Vec3f radiance);
template <template <class> class Data>
LightRow make_light_row(LightKind kind, Vec3f radiance, const Data<Scalar>& data) {
  LightRow row = make_light_row(kind, radiance);
  row.set_data(data);
  return row;
}

/// Scene data for placing lights.
struct LightContext {
  const IntegratorSettings& integrator;
  std::span<const TextureRow> textures;  ///< those of the description
  SpectrumSet* spectra;                  ///< null in RGB mode
  Envmap& envmap;                        ///< environment map of the scene, filled by its light
  std::vector<LightFrameRow>& frames;
  std::vector<std::string>& warnings;

  /// The emission of a light. Throws SceneError at `where`.
  LightEmission emission(const SpectrumInput& emission, const SourceLocation& where) const;
  /// Only the spectrum.
  SpectrumRow emission_row(const SpectrumInput& emission, const SourceLocation& where) const;
  /// Row of a texture. Throws SceneError at `where` if it does not exist or cannot be used by lights.
  std::uint32_t texture_row(TextureId id, const SourceLocation& where) const;
  /// Adds a row to LightView::frames; returns its index.
  std::uint32_t add_frame(const LightFrameRow& frame);
  /// A light of a kind, without texture.
  template <class Kind> CompiledLight light(const LightEmission& emission) const {
    return {make_light_row(kLightKind<Kind>, emission.rgb), emission.spectrum};
  }
  template <class Kind, template <class> class Data>
  CompiledLight light(const LightEmission& emission, const Data<Scalar>& data) const {
    return {make_light_row(kLightKind<Kind>, emission.rgb, data), emission.spectrum};
  }
};

}  // namespace sheaf

// Rows of lights, and the scene data from which lights are compiled.
#pragma once

#include "core/color/spectrum_row.h"
#include "core/io/error.h"
#include "scene/description/inputs.h"
#include "scene/tables/envmap.h"
#include "scene/tables/light.h"
#include "scene/tables/texture.h"

#include <span>
#include <string>
#include <vector>

namespace sheaf {

class SpectrumSet;
struct IntegratorSettings;

/// The emission of a light in both color modes.
struct LightEmission {
  Vec3f rgb;             ///< linear Rec.709, RGB mode; 1 for textures
  SpectrumRow spectrum;  ///< spectral mode; relative to D65 for textures
};

/// A light that is not on a shape.
struct CompiledLight {
  LightRow row;
  SpectrumRow spectrum = {};  ///< spectrum of LightRecord::radiance, in spectral mode
};

/// Makes a row without texture.
LightRow make_light_row(LightKind kind, Vec3f radiance);
template <template <class> class Data>
LightRow make_light_row(LightKind kind, Vec3f radiance, const Data<Scalar>& data) {
  LightRow row = make_light_row(kind, radiance);
  row.set_data(data);
  return row;
}

/// Scene data from which lights are compiled.
struct LightContext {
  const IntegratorSettings& integrator;
  std::span<const TextureRow> textures;  ///< those of the description
  SpectrumSet* spectra;                  ///< null in RGB mode
  Envmap& envmap;                        ///< environment map of the scene, filled by its light
  std::vector<LightFrameRow>& frames;
  std::vector<std::string>& warnings;
  LightKind kind = {};  ///< of the next light: the first kind that lists its description

  /// The emission of a light. Throws SceneError at `where`.
  LightEmission emission(const SpectrumInput& emission, const SourceLocation& where) const;
  /// Only the spectrum.
  SpectrumRow emission_row(const SpectrumInput& emission, const SourceLocation& where) const;
  /// Row of a texture. Throws SceneError at `where` if it does not exist or cannot be used by lights.
  std::uint32_t texture_row(TextureId id, const SourceLocation& where) const;
  /// Adds a row to LightView::frames; returns its index.
  std::uint32_t add_frame(const LightFrameRow& frame);
  /// A light of `kind`, without texture.
  CompiledLight light(const LightEmission& emission) const {
    return {make_light_row(kind, emission.rgb), emission.spectrum};
  }
  template <template <class> class Data>
  CompiledLight light(const LightEmission& emission, const Data<Scalar>& data) const {
    return {make_light_row(kind, emission.rgb, data), emission.spectrum};
  }
};

}  // namespace sheaf

// Compiles the media of a description.
#pragma once

#include "scene/compile/compile.h"
#include "scene/spectra/spectrum_set.h"
#include "scene/tables/scene_view.h"

#include <span>

namespace sheaf {

/// A medium with its position.
struct PlacedMedium {
  const MediumDescription* description;
  std::uint32_t phase = 0;                  ///< row of its phase function's material
  const SggxDescription* flakes = nullptr;  ///< the phase function, if it is SGGX
  std::vector<GridBox> boxes;               ///< of all shapes that contain it, at the first key; world space, metres
  GridBox scene;                            ///< of the whole scene, for media that no shape contains
};

/// Results of compile_media() besides MediumTables.
struct CompiledMedia {
  std::vector<SpectrumRow> spectra;  ///< kMediumSpectra per medium; empty in RGB mode
  std::vector<PlacedGrid> places;    ///< per grid
  std::vector<std::string> warnings;
};

/// Reads grids and adds the rows of media, grids and majorants to `tables`. `set` makes rows of spectra in spectral
/// mode. `step_size` is that of ray marching, metres; 0: 1/100 of each medium's diagonal. Throws SceneError for
/// unreadable files, grids with a wrong number of channels, and singular transforms.
CompiledMedia compile_media(std::span<const PlacedMedium> media, SpectrumSet* set, float step_size,
                            MediumTables& tables);

/// Throws SceneError at the first medium whose coefficients or emission are not finite somewhere, because tracking
/// would then take steps of length zero. `tables` are those of `scene`.
void check_media(const SceneView& scene, std::span<const MediumDescription> media, const MediumTables& tables);

}  // namespace sheaf

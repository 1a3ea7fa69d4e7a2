// Compiles the media of a description.
#pragma once

#include "scene/compile/compile.h"
#include "scene/spectra/spectrum_set.h"
#include "scene/tables/scene.h"

#include <span>

namespace sheaf {

/// A medium with its position.
struct PlacedMedium {
  const MediumDescription* description;
  std::uint32_t phase = 0;                  ///< row of its phase function's material
  const SggxDescription* flakes = nullptr;  ///< the phase function, if it is SGGX
  std::vector<GridBox> boxes;               ///< of all shapes that contain it; world space, metres
  GridBox scene;                            ///< of the whole scene, for media that no shape contains
};

/// The tables of all media.
struct CompiledMedia {
  std::vector<MediumRow> rows;
  std::vector<SpectrumRow> spectra;  ///< kMediumSpectra per medium; empty in RGB mode
  std::vector<BrickGrid> grids;
  std::vector<BrickGridRow> grid_rows;
  std::vector<MajorantGrid> majorants;
  std::vector<MajorantGridRow> majorant_rows;
  std::vector<PlacedGrid> places;  ///< per grid
  std::vector<std::string> warnings;
};

/// Reads grids and makes the rows. `set` makes rows of spectra in spectral mode. `step_size` is that of ray marching,
/// metres; 0: 1/100 of each medium's diagonal. Throws SceneError for unreadable files, grids with a wrong number of
/// channels, and singular transforms.
CompiledMedia compile_media(std::span<const PlacedMedium> media, SpectrumSet* set, float step_size);

/// Throws SceneError at the first medium whose coefficients or emission are not finite somewhere, because tracking
/// would then take steps of length zero. `grids` and `majorants` are those of CompiledMedia.
void check_media(const SceneView& scene, std::span<const MediumDescription> media, std::span<const BrickGrid> grids,
                 std::span<const MajorantGrid> majorants);

}  // namespace sheaf

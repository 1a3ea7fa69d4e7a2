// Media of a description as rows of tables.
#pragma once

#include "scene/compile/compile.h"
#include "scene/compile/spectra.h"
#include "scene/tables/scene.h"

#include <span>

namespace sheaf {

/// A medium where it lies.
struct PlacedMedium {
  const MediumDescription* description;
  std::uint32_t phase = 0;                  ///< row of the material that is its phase function
  const SggxDescription* flakes = nullptr;  ///< that function, if it is this
  std::vector<GridBox> boxes;               ///< around each of the shapes that hold it; world space, metres
  GridBox scene;                            ///< around everything, for media that no shape holds
};

/// The tables of all media.
struct CompiledMedia {
  std::vector<MediumRow> rows;
  std::vector<SpectrumRow> spectra;  ///< kMediumSpectra for each; empty in RGB mode
  std::vector<BrickGrid> grids;
  std::vector<BrickGridRow> grid_rows;
  std::vector<MajorantGrid> majorants;
  std::vector<MajorantGridRow> majorant_rows;
  std::vector<PlacedGrid> places;  ///< of each grid
  std::vector<std::string> warnings;
};

/// Reads grids and makes the rows. `set`: what makes rows of spectra, in spectral mode. `step_size`: of ray marching,
/// metres; 0: a hundredth of each medium's diagonal. Throws SceneError for files that cannot be read, grids of a wrong
/// number of channels and transforms that are singular.
CompiledMedia compile_media(std::span<const PlacedMedium> media, SpectrumSet* set, float step_size);

/// Throws SceneError at the place of the first medium whose coefficients or emission are not finite somewhere: where
/// tracking would take steps of no length. `grids` and `majorants` are CompiledMedia's.
void check_media(const SceneView& scene, std::span<const MediumDescription> media, std::span<const BrickGrid> grids,
                 std::span<const MajorantGrid> majorants);

}  // namespace sheaf

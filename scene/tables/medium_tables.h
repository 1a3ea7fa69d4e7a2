// The media of a scene: rows, grids with their majorants, and the boundaries between media.
#pragma once

#include "scene/tables/brick_grid.h"
#include "scene/tables/majorant_grid.h"
#include "scene/tables/medium.h"
#include "scene/tables/table_bytes.h"

#include <optional>
#include <vector>

namespace sheaf {

/// Media for kernels. References to media are 0 for vacuum, else 1 + the row.
struct MediumView {
  const MediumRow* rows = nullptr;
  const BoundaryRow* boundaries = nullptr;
  BrickGridView grids;
  const MajorantGridRow* majorants = nullptr;
  const BlackbodyTable* blackbodies = nullptr;  ///< RGB mode, if a medium has a temperature
  std::uint32_t camera_medium = 0;              ///< medium that contains the camera
  std::uint32_t outer_medium = 0;               ///< medium that surrounds the scene
  /// Radius around SceneView::center at which unbounded media end; infinite if no light is at infinity.
  float outer_radius = kInfinity;
};

/// Owns the tables of media.
struct MediumTables {
  std::vector<MediumRow> rows;
  std::vector<BoundaryRow> boundaries;
  std::vector<BrickGrid> grids;
  std::vector<BrickGridRow> grid_rows;  ///< one per grid
  std::vector<MajorantGrid> majorants;
  std::vector<MajorantGridRow> majorant_rows;  ///< one per majorant grid
  std::optional<BlackbodyTable> blackbodies;
  std::uint32_t camera_medium = 0, outer_medium = 0;
  float outer_radius = kInfinity;

  MediumView view() const {
    return {rows.data(),
            boundaries.data(),
            {grid_rows.data()},
            majorant_rows.data(),
            blackbodies ? &*blackbodies : nullptr,
            camera_medium,
            outer_medium,
            outer_radius};
  }
  /// Memory in bytes.
  std::size_t bytes() const {
    std::size_t sum = bytes_of(rows, boundaries);
    for (const BrickGrid& grid : grids) sum += grid.bytes();
    for (const MajorantGrid& grid : majorants) sum += grid.bytes();
    return sum;
  }
};

}  // namespace sheaf

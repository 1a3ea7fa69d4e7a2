// The media of a scene: rows, grids with their majorants, and the boundaries between media.
#pragma once

#include "scene/tables/brick_grid.h"
#include "scene/tables/majorant_grid.h"
#include "scene/tables/medium.h"
#include "scene/tables/table_bytes.h"

#include <algorithm>
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
  std::uint32_t camera_medium = 0;              ///< medium that contains the first camera when the shutter opens
  /// The media in which camera rays start, in the order of camera and time. Each camera has a row for time 0. Empty if
  /// all rays start in camera_medium.
  const CameraMediumRow* camera_media = nullptr;
  std::uint32_t camera_medium_count = 0;         ///< number of rows
  const SurroundingRow* surroundings = nullptr;  ///< null: each boundary has the same medium outside of it everywhere
  std::uint32_t outer_medium = 0;                ///< medium that surrounds the scene
  /// Radius around SceneView::center at which unbounded media end; infinite if no light is at infinity.
  float outer_radius = kInfinity;
  /// Rays in some media are connected to lights by segments; see connects_segments().
  bool connects_segments = false;
};

/// Whether rays in a medium are connected to lights (kernels/stages/segment_lights.cpp).
inline bool connects_segments(const MediumRow& medium) { return (medium.flags & kMediumConnects) != 0; }

/// Owns the tables of media.
struct MediumTables {
  std::vector<MediumRow> rows;
  std::vector<BoundaryRow> boundaries;
  std::vector<SurroundingRow> surroundings;
  std::vector<CameraMediumRow> camera_media;
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
            camera_media.data(),
            static_cast<std::uint32_t>(camera_media.size()),
            surroundings.empty() ? nullptr : surroundings.data(),
            outer_medium,
            outer_radius,
            std::any_of(rows.begin(), rows.end(), [](const MediumRow& row) { return connects_segments(row); })};
  }
  /// Memory in bytes.
  std::size_t bytes() const {
    std::size_t sum = bytes_of(rows, boundaries, surroundings, camera_media);
    for (const BrickGrid& grid : grids) sum += grid.bytes();
    for (const MajorantGrid& grid : majorants) sum += grid.bytes();
    return sum;
  }
};

}  // namespace sheaf

// Grids of signed distances: where rays meet the surface at which they are 0, exactly, in double precision.
#pragma once

#include "scene/tables/quadric.h"

#include <utility>

namespace sheaf {

/// One grid, by its rows and the beginning of its tables.
struct SdfGridView {
  const QuadricRow* placement;
  const SdfGridRow* grid;
  const float* values;         ///< those of the grid
  const std::uint32_t* cells;  ///< those of the grid, two words each
};
/// From the scene's tables, by the rows of a shape.
SdfGridView sdf_grid_view(const QuadricRow* quadrics, const SdfGridRow& grid, const ShapeRow& shape,
                          const float* values, const std::uint32_t* cells);

/// Whether the surface passes through the cell with this least corner: the values at its corners don't all have the
/// same sign.
bool holds_surface(const SdfGridRow& grid, const float* values, std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// World-space bounds of a cell, larger than it is by more than Embree's rounding errors.
QuadricBounds sdf_cell_bounds(const SdfGridView& view, std::uint32_t cell);

/// The nearest intersection with the surface in one cell with t in (t_near, t_far); along a ray a cubic polynomial is
/// to be solved (Marmitt et al. 2004; Hansson-Soederlund, Evans and Akenine-Moeller 2022). Between neighbouring cells
/// there are no gaps: both see the same value where the ray passes from one to the other.
std::optional<QuadricHit> intersect_sdf_cell(const SdfGridView& view, std::uint32_t cell, Vec3f origin, Vec3f direction,
                                             float t_near, float t_far) noexcept;

}  // namespace sheaf

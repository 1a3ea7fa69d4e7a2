// Grids of signed distances: exact intersection of rays with their zero level set, in double precision.
#pragma once

#include "scene/accel/quadric.h"

#include <utility>

namespace sheaf {

/// One grid: its rows and the start of its data.
struct SdfGridView {
  const QuadricRow* placement;
  const SdfGridRow* grid;
  const float* values;         ///< values of the grid
  const std::uint32_t* cells;  ///< cells of the grid, two words each
};
/// Makes the view from the scene's tables and the rows of a shape.
SdfGridView sdf_grid_view(const QuadricRow* quadrics, const SdfGridRow& grid, const ShapeRow& shape,
                          const float* values, const std::uint32_t* cells);

/// Whether the surface passes through the cell with this minimum corner: the values at its corners are not all of the
/// same sign.
bool holds_surface(const SdfGridRow& grid, const float* values, std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// World-space bounds of a cell, enlarged by more than Embree's rounding errors.
Bounds3f sdf_cell_bounds(const SdfGridView& view, std::uint32_t cell);

/// Nearest intersection with the surface inside one cell, with t in (t_near, t_far). Solves a cubic polynomial along
/// the ray (Marmitt et al. 2004; Hansson-Soederlund, Evans and Akenine-Moeller 2022). There are no gaps between
/// neighboring cells: both compute the same value at the point where the ray crosses their common face.
std::optional<QuadricHit> intersect_sdf_cell(const SdfGridView& view, std::uint32_t cell, Vec3f origin, Vec3f direction,
                                             float t_near, float t_far) noexcept;

}  // namespace sheaf

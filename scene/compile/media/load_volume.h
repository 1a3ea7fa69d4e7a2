// Loads volumes of all formats.
#pragma once

#include "scene/compile/compile.h"
#include "scene/tables/brick_grid.h"

namespace sheaf {

/// Reads a grid volume. Throws SceneError at `where` for errors of the readers (scene/formats/vol_file.h,
/// scene/formats/sparse_volume.h) and for too many bricks. A sparse grid may take at most 64 MiB plus 512 times its
/// size in the file. `grid_to_local` maps to the space defined by GridVolumeDescription::format. The filter is applied
/// by make_brick_grid_row() and make_majorant_grid().
BrickGrid load_volume(const GridVolumeDescription& description, const SourceLocation& where);

/// Row of a grid loaded by load_volume(). Throws SceneError at `where` if the inverse transform is not finite in 32-bit
/// floats.
BrickGridRow place_grid(const BrickGrid& grid, const Transform& to_world, const GridVolumeDescription& description,
                        const SourceLocation& where);

/// Describes a grid for reports.
PlacedGrid describe_grid(const BrickGrid& grid, const Transform& to_world, const GridVolumeDescription& description,
                         const SourceLocation& where);

/// Border mode of a dense grid.
GridBorder border_of(GridVolumeDescription::Wrap wrap);

}  // namespace sheaf

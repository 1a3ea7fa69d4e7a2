// Volumes from files of any kind.
#pragma once

#include "scene/compile/compile.h"
#include "scene/tables/brick_grid.h"

namespace sheaf {

/// Reads the file of a grid volume. Throws SceneError at `where` for what the readers of files throw
/// (scene/formats/vol_file.h, scene/formats/nanovdb.h), and for volumes of too many bricks; of a .nvdb file, of more
/// than 64 MiB and 512 times the bytes that the grid takes in it. The grid's `grid_to_local` leads to the space that
/// GridVolumeDescription::format names; the description's filter is left to make_brick_grid_row() and
/// make_majorant_grid().
BrickGrid load_volume(const GridVolumeDescription& description, const SourceLocation& where);

/// The row of a grid that load_volume() made of the description, in its place. Throws SceneError at `where` if the
/// transform from the world is beyond 32-bit floats.
BrickGridRow place_grid(const BrickGrid& grid, const Transform& to_world, const GridVolumeDescription& description,
                        const SourceLocation& where);

/// What people are told of such a grid.
PlacedGrid describe_grid(const BrickGrid& grid, const Transform& to_world, const GridVolumeDescription& description,
                         const SourceLocation& where);

/// What is outside of a dense grid.
GridBorder border_of(GridVolumeDescription::Wrap wrap);

}  // namespace sheaf

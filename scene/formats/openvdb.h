// OpenVDB files: named sparse volumes. Sheaf's own reader, which needs no library and survives damaged files.
#pragma once

#include "scene/description/voxels.h"

#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// Reads a grid of a .vdb file: the grid named `grid`, or the first one if `grid` is empty. Values are single floats,
/// doubles, 32- or 64-bit integers, or vectors of three floats or doubles; floats may be stored as halves. They are
/// converted to 32-bit floats. Inactive voxels count, too. The file may be uncompressed, deflated, or compressed with
/// Blosc if the build includes it. Of several grids with the same name, 'name[1]' is the second. Throws SceneError for
/// a missing, truncated or corrupt file, unknown grid names, level sets, other value types and trees, transforms that
/// are not affine, values that are not finite, and files of versions before 1.0 (format 222) or without grid positions.
SparseVolume read_openvdb(const std::filesystem::path& file, const std::string& grid);

/// Names of the grids in their order in the file. Throws as read_openvdb() does for invalid files.
std::vector<std::string> openvdb_grid_names(const std::filesystem::path& file);

/// Whether read_openvdb() finds a grid of this name. Throws as openvdb_grid_names() does.
bool has_openvdb_grid(const std::filesystem::path& file, const std::string& grid);

}  // namespace sheaf

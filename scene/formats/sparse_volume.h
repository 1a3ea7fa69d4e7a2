// Files of named sparse volumes: NanoVDB and OpenVDB.
#pragma once

#include "scene/description/voxels.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace sheaf {

/// Reads a grid of a .nvdb or .vdb file, which is recognized by its first bytes: the grid named `grid`, or the first
/// one if `grid` is empty. Throws SceneError, see read_nanovdb() and read_openvdb().
SparseVolume read_sparse_volume(const std::filesystem::path& file, const std::string& grid);

/// Whether the file has a grid of this name. Throws SceneError for invalid files.
bool has_sparse_grid(const std::filesystem::path& file, const std::string& grid);

/// Converts a number of a file. Doubles beyond the range of floats become infinite.
template <class T> float to_float(T value) {
  if constexpr (std::is_same_v<T, double>) {
    if (std::fabs(value) > double{std::numeric_limits<float>::max()}) return std::numeric_limits<float>::infinity();
  }
  return static_cast<float>(value);
}

/// The name of a grid for a message: truncated if it is long.
std::string displayed_grid(const std::string& name);

/// Index of the grid `name` among the grids of a file; 0 for an empty name. Throws SceneError at `file` if it is
/// missing; the message lists the names and suggests the nearest.
std::size_t find_grid(const std::vector<std::string>& names, const std::string& name, const std::string& file);

}  // namespace sheaf

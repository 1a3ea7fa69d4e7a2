// Polygons of mesh files.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sheaf {

/// Marks a corner whose vertex does not exist in the file.
inline constexpr std::uint32_t kMissingVertex = 0xffffffffu;

/// Polygons by vertex indices, as mesh files list them.
struct PolygonList {
  std::vector<std::uint32_t> corners;  ///< vertex indices of all polygons in sequence
  std::vector<std::size_t> ends;       ///< end of each polygon in `corners`; each has at least 3 corners
  std::size_t too_short = 0;           ///< number of polygons with fewer corners, which are dropped
  std::string first_missing = {};      ///< error message for the first kMissingVertex
};

/// Triangulates the polygons and appends them to a mesh that has their vertices. Drops polygons with a kMissingVertex.
/// Adds one warning for each kind of problem. Returns for each new triangle the index of its polygon.
std::vector<std::uint32_t> append_polygons(const PolygonList& polygons, Mesh& mesh, std::vector<std::string>& warnings);

}  // namespace sheaf

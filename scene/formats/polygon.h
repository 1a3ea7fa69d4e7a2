// Polygons of mesh files, and how they become triangles.
#pragma once

#include "scene/description/description.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// A corner whose vertex the file lacks.
inline constexpr std::uint32_t kMissingVertex = 0xffffffffu;

/// Polygons by their vertices, as a mesh file lists them.
struct PolygonList {
  std::vector<std::uint32_t> corners;  ///< vertices of all polygons, one polygon after the other
  std::vector<std::size_t> ends;       ///< where in `corners` each polygon ends; all have three corners or more
  std::size_t too_short = 0;           ///< polygons with fewer corners, left out
  std::string first_missing = {};      ///< what is wrong with the first kMissingVertex, for the user
};

/// Adds the polygons, cut into triangles, to a mesh that has their vertices; those with a kMissingVertex are left out.
/// Adds a warning for each kind of polygon
/// that could not be used as it is. Returns for each new triangle the polygon, counted from 0, that it is a part of.
std::vector<std::uint32_t> append_polygons(const PolygonList& polygons, Mesh& mesh, std::vector<std::string>& warnings);

/// Three corners of a polygon, counted from 0, in the polygon's order.
using PolygonTriangle = std::array<std::uint32_t, 3>;

/// Replaces `out` by triangles that cover a polygon of at least three corners, seen along its mean normal (Newell).
/// Convex polygons become a fan around the first corner, concave ones are cut ear by ear (Meisters 1975); corners on a
/// straight line may go unused. Returns false if no ear is left, as happens where the outline crosses itself, or if
/// cutting takes too long: then the rest of it has become a fan. Polygons without a finite area become a fan as well.
bool triangulate_polygon(std::span<const Vec3f> corners, std::vector<PolygonTriangle>& out);

}  // namespace sheaf

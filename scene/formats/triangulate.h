// Triangulation of polygons with any number of corners, for mesh files and for imported models. It depends only on
// core/math/vec.h: tools/importer/ compiles it as well.
#pragma once

#include "core/math/vec.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// Three corner indices of a polygon, in the polygon's order.
using PolygonTriangle = std::array<std::uint32_t, 3>;

/// Replaces `out` by triangles that cover a polygon of at least three corners, projected along its mean normal
/// (Newell). Convex polygons become a fan around the first corner; concave ones are triangulated by ear clipping
/// (Meisters 1975). Collinear corners may stay unused. Returns false if no ear is left, for example if the outline
/// intersects itself, or if clipping takes too long; the rest then becomes a fan. Polygons without a finite area become
/// a fan as well.
bool triangulate_polygon(std::span<const Vec3f> corners, std::vector<PolygonTriangle>& out);

}  // namespace sheaf

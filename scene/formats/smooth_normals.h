// Vertex normals for meshes without normals, by smoothing groups or crease angle.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

#include <span>

namespace sheaf {

/// Edges are creases if the normals of their triangles differ by more, in degrees.
inline constexpr float kCreaseAngle = 50;

/// Computes vertex normals as angle-weighted means of the triangle normals that are smooth there. Vertices at the same
/// position count as one; vertices with several normals are split. `groups`: smoothing group of each triangle;
/// triangles of the same group are smooth where they meet, and 0 is flat. Without groups, triangles are smooth across
/// edges that exactly two triangles share and that are not creases.
void compute_creased_normals(Mesh& mesh, std::span<const std::uint32_t> groups);

/// Computes smooth normals that are equal for all vertices at the same position.
void compute_welded_normals(Mesh& mesh);

}  // namespace sheaf

// Normals for models that have none: smooth within smoothing groups, or between edges that are sharp.
#pragma once

#include "scene/description/description.h"

#include <span>

namespace sheaf {

/// Where the normals of two neighbouring triangles differ by more, in degrees, the edge between them is a crease.
inline constexpr float kCreaseAngle = 50;

/// Gives every vertex a normal: the mean of the normals of the triangles that are smooth there, weighted by their
/// angles. Vertices at one place count as one, and vertices with several normals are split. `groups`: of each triangle
/// the smoothing group, those of one group being smooth where they meet; 0 is flat. Without groups, triangles are
/// smooth across edges that no other triangle shares and that are no creases.
void compute_creased_normals(Mesh& mesh, std::span<const std::uint32_t> groups);

/// Smooth normals that are the same in all vertices at one place.
void compute_welded_normals(Mesh& mesh);

}  // namespace sheaf

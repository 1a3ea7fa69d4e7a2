// Subdivision surfaces of triangles.
#pragma once

#include "scene/description/description.h"

namespace sheaf {

/// The triangles, each cut into 4^levels, of the surface that Loop's subdivision tends to ("Smooth Subdivision Surfaces
/// Based on Triangles", 1987; weights of Warren 1995), with the vertices on that surface and its normals there. The
/// boundary is the cubic B-spline of the control points along it (Hoppe et al., "Piecewise Smooth Surface
/// Reconstruction", 1994). `control` is a mesh of positions and triangles alone, in range. Throws SceneError unless
/// each edge has one or two triangles, oriented alike, and each vertex one fan of them; and for more than
/// kMaxSubdivided triangles.
Mesh subdivide(const Mesh& control, int levels);

inline constexpr std::size_t kMaxSubdivided = std::size_t{1} << 26;

}  // namespace sheaf

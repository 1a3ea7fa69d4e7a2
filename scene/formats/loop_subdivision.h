// Loop subdivision surfaces.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

namespace sheaf {

/// Subdivides each triangle into 4^levels triangles by Loop's scheme ("Smooth Subdivision Surfaces Based on Triangles",
/// 1987; weights of Warren 1995). Moves the vertices to the limit surface and returns its normals there. The boundary
/// is the cubic B-spline of its control points (Hoppe et al., "Piecewise Smooth Surface Reconstruction", 1994).
/// `control` holds only positions and triangles, with indices in range. Throws SceneError unless the mesh is an
/// oriented manifold: each edge has one or two consistently oriented triangles, each vertex a single fan. Also throws
/// for more than kMaxSubdivided triangles.
Mesh subdivide(const Mesh& control, int levels);

inline constexpr std::size_t kMaxSubdivided = std::size_t{1} << 26;

}  // namespace sheaf

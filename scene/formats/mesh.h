// Processing of triangle meshes between file and scene, and the meshes of polyhedral shapes.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

#include <cstddef>

namespace sheaf {

// Processing order from a shape's mesh to a scene mesh, which gives the results of Mitsuba 3:
//   1. if face_normals is set, clear `normals`;
//   2. transform_mesh();
//   3. drop_degenerate_triangles();
//   4. unless face_normals is set, compute_vertex_normals() if there are none (Nori renders such meshes faceted);
//   5. if flip_normals is set, flip_mesh().
// The geometric normal of a triangle a b c is (b - a) x (c - a). It determines which side emits and which is the
// interior.

/// Maximum coordinate for intersection in single precision: Embree's triangle test multiplies three lengths.
inline constexpr float kMaxMeshCoordinate = 1e12f;

/// Returns [-1, 1]^2 in the xy plane, normal +z, uv (0, 0) at (-1, -1).
Mesh rectangle_mesh();
/// Returns [-1, 1]^3, normals outwards, each face with its own uv square, in Mitsuba's layout.
Mesh cube_mesh();

/// Throws SceneError unless vertex and attribute arrays have matching lengths and all indices are in range.
void check_mesh(const Mesh& mesh, const SourceLocation& where);

/// Transforms to world space: positions by the transform, normals by the inverse transpose. Afterwards `normals` is
/// empty or of unit length; vertices without a usable normal (zero or not finite) get a smooth one. The vertex normals
/// determine the front side, independent of winding and mirroring transforms: triangles are reordered so that the
/// geometric normal is on the side of their vertex normals. Without normals the order is kept, so a mirroring transform
/// flips the geometric normal.
void transform_mesh(Mesh& mesh, const Transform& to_world);
/// Applies the linear part of a transform and leaves the translation in `to_world`: far from the origin, floats cannot
/// hold the sum.
void apply_linear_part(Mesh& mesh, Transform& to_world);

/// Swaps front and back: reverses triangles and negates normals.
void flip_mesh(Mesh& mesh);

/// Returns the three heights of each triangle, the distances of its corners from the opposite edges. With `relative`,
/// in tenths of the mean edge length, where each triangle's edges count. No triangle may be degenerate.
std::vector<float> edge_distances(const Mesh& mesh, bool relative);

/// Replaces `normals` by smooth ones: triangle normals weighted by the angle at the vertex (Thuermer and Wuethrich
/// 1998). Vertices without a triangle get +z.
void compute_vertex_normals(Mesh& mesh);

/// Appends copies of the vertices `sources`, with all their attributes.
void append_vertex_copies(Mesh& mesh, const std::vector<std::uint32_t>& sources);

/// Returns the given triangles in the given order, with the vertices that they use and all attributes. Vertices are in
/// order of first use. `triangles` and the indices of these triangles must be in range.
Mesh extract_triangles(const Mesh& mesh, const std::vector<std::uint32_t>& triangles);

/// Returns the indices of all triangles except those with a non-finite vertex, an index out of range or zero area. Area
/// counts as zero if single precision cannot determine the normal: if twice the area is below 1e-37, or below 2^-22
/// times the square of the longest edge. Triangles with a coordinate beyond kMaxMeshCoordinate are excluded, too.
std::vector<std::uint32_t> usable_triangles(const Mesh& mesh);

/// Whether all coordinates of a triangle's vertices are finite and at most kMaxMeshCoordinate. Its indices must be in
/// range.
bool is_traceable_triangle(const Mesh& mesh, std::uint32_t triangle);

/// Removes triangles that are not usable and returns their number. If it removes any, it also removes unreferenced
/// vertices.
std::size_t drop_degenerate_triangles(Mesh& mesh);

/// Returns for each vertex the first vertex at the same position.
std::vector<std::uint32_t> same_positions(const Mesh& mesh);

/// Returns the vertices of the open edges, those without equally many triangles on both sides. Vertices at the same
/// position count as one. Empty for a closed surface, independent of vertex splits. O(n log n).
std::vector<std::array<std::uint32_t, 2>> open_edges(const Mesh& mesh);

}  // namespace sheaf

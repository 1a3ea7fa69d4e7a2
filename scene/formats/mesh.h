// What is done to triangle meshes between the file and the scene, and the meshes of shapes with flat sides.
#pragma once

#include "scene/description/description.h"

#include <cstddef>

namespace sheaf {

// A shape's mesh becomes a mesh of the scene in this order, which gives the results of Mitsuba 3:
//   1. where face_normals is set, `normals` is cleared;
//   2. transform_mesh();
//   3. drop_degenerate_triangles();
//   4. unless face_normals is set, compute_vertex_normals() if there are none (Nori shows such meshes faceted);
//   5. where flip_normals is set, flip_mesh().
// The geometric normal of a triangle a b c is (b - a) x (c - a). It decides which side emits and which is inside.

/// Coordinates beyond this cannot be intersected in single precision: Embree's triangle test multiplies three lengths.
inline constexpr float kMaxMeshCoordinate = 1e12f;

/// [-1, 1]^2 in the xy plane, normal +z, uv (0, 0) at (-1, -1).
Mesh rectangle_mesh();
/// [-1, 1]^3, normals outwards, each face with its own uv square, laid as Mitsuba lays them.
Mesh cube_mesh();

/// Throws SceneError unless the arrays of vertices and attributes agree in length and all indices are in range.
void check_mesh(const Mesh& mesh, const SourceLocation& where);

/// To world space: positions by the transform, normals by the inverse transpose. Afterwards `normals` is empty or of
/// unit length throughout: vertices without a usable normal (zero or not finite) get a smooth one.
/// Which side is the front follows the vertex normals, whatever the winding in the file and whether or not the
/// transform mirrors: triangles are reordered so that the geometric normal lies on the side of their vertex normals.
/// Without normals the order stays, so that a mirroring transform turns the geometric normal around.
void transform_mesh(Mesh& mesh, const Transform& to_world);

/// Turns the front to the back: reverses triangles and negates normals.
void flip_mesh(Mesh& mesh);

/// Of each triangle the distances of its corners from the edges across, its heights; with `relative` in tenths of the
/// mean length of all edges, each triangle's counted. No triangle may be degenerate.
std::vector<float> edge_distances(const Mesh& mesh, bool relative);

/// Replaces `normals` by smooth ones: means of the triangles' normals weighted by the angle at the vertex (Thuermer and
/// Wuethrich 1998). Vertices without a triangle get +z.
void compute_vertex_normals(Mesh& mesh);

/// Appends copies of vertices, by their indices, with all that they have.
void append_vertex_copies(Mesh& mesh, const std::vector<std::uint32_t>& sources);

/// The given triangles alone, in the given order, with the vertices that they need and their attributes. Vertices come
/// in the order of first use. `triangles` and the indices of these triangles must be in range.
Mesh extract_triangles(const Mesh& mesh, const std::vector<std::uint32_t>& triangles);

/// All triangles but those that have a non-finite vertex, an index out of range or zero area, in order. Area counts as
/// zero where single precision cannot tell the normal: if twice the area is below 1e-37, or below 2^-22 times the
/// square of the longest edge. Triangles with a coordinate beyond kMaxMeshCoordinate are left out too.
std::vector<std::uint32_t> usable_triangles(const Mesh& mesh);

/// Removes the triangles that are not usable; returns how many. If any is, vertices that nothing refers to any more
/// leave as well.
std::size_t drop_degenerate_triangles(Mesh& mesh);

/// For each vertex the first one at the same place.
std::vector<std::uint32_t> same_places(const Mesh& mesh);

/// How many edges have a triangle on one side alone, vertices in one place being one: 0 for a closed surface, however
/// its vertices are split. In O(n log n).
std::size_t count_open_edges(const Mesh& mesh);

}  // namespace sheaf

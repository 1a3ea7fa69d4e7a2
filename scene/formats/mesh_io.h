// Reading triangle meshes from files: Wavefront OBJ, Stanford PLY, Mitsuba's serialized meshes.
#pragma once

#include "scene/description/description.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// What a mesh file held, and what had to be repaired on the way.
struct MeshFile {
  Mesh mesh;  ///< at least one triangle; all indices in range; see the readers for normals and uvs
  std::vector<std::string> warnings;  ///< for the user, without the file's name
  bool is_split = false;     ///< vertices at one place differ in their texture coordinates alone: normals are one there
  std::string texture = {};  ///< the picture that a PLY file's comment names; may be empty
  bool face_normals = false;  ///< the file itself wants to be shown faceted, as ShapeDescription::face_normals says
};

using BadFaces = MeshFileShape::BadFaces;

// All readers throw SceneError, with the line where it is known, for files that are missing, empty, truncated or
// malformed, and for indices out of range. With BadFaces::kDrop faces whose vertices are out of range are left out and
// other indices out of range ignored, with a warning; a file without any other face is an error all the same. Positions
// that are NaN or infinite are accepted as the file gives them (drop_degenerate_triangles() removes what uses them).
// Normals are as long as the file has them; a vertex without a usable one has (0, 0, 0) if others have theirs, and
// `normals` is empty if none has (compute_vertex_normals() and transform_mesh() fill in). Vertices without a texture
// coordinate get (0, 0), and `uvs` is empty if none has one. Polygons with more than three corners, convex or concave,
// are cut into triangles.

/// Wavefront OBJ. Objects and groups become one mesh; materials (scene/formats/obj.h has them), lines,
/// points and curves are ignored. Corners that share position, normal and texture coordinate share a vertex.
/// `flip_tex_coords`: v becomes 1 - v.
MeshFile read_obj(const std::filesystem::path& file, bool flip_tex_coords, BadFaces bad_faces = BadFaces::kError);

/// Stanford PLY: ASCII and binary in both byte orders, polygons and triangle strips. Texture coordinates may be called
/// u v, s t, texture_u texture_v or texture_s texture_t, or be those of the faces' corners, in a list texcoord, which
/// then count; vertices whose corners differ are split. scene/formats/ply_attributes.h tells which properties are
/// attributes; other elements and properties are skipped, with warnings.
MeshFile read_ply(const std::filesystem::path& file, bool flip_tex_coords = false,
                  BadFaces bad_faces = BadFaces::kError);

/// read_obj(), read_ply() or read_serialized() (scene/formats/serialized.h), as the shape says.
MeshFile read_mesh(const MeshFileShape& shape);

/// The bytes of a regular file, uncompressed if its name ends in .gz. Throws SceneError, naming `what` is sought ("OBJ
/// file"), if it can't be read.
std::string read_mesh_bytes(const std::filesystem::path& file, std::string_view what);

/// The same of a file that begins with text: without the byte order mark of UTF-8. Throws SceneError for text in UTF-16
/// or UTF-32, too.
std::string read_mesh_text(const std::filesystem::path& file, std::string_view what);

}  // namespace sheaf

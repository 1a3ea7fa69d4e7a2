// Readers of triangle mesh files: Wavefront OBJ, Stanford PLY, Mitsuba's serialized meshes.
#pragma once

#include "core/io/error.h"
#include "scene/description/shapes.h"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// A mesh from a file, and the repairs made while reading.
struct MeshFile {
  Mesh mesh;  ///< at least one triangle; all indices in range; see the readers for normals and uvs
  std::vector<std::string> warnings;  ///< for the user, without the file name
  /// Vertices at the same position differ only in texture coordinates and share a normal.
  bool is_split = false;
  std::string texture = {};   ///< texture image named in a PLY comment; may be empty
  bool face_normals = false;  ///< the file requests ShapeDescription::face_normals
};

using BadFaces = MeshFileShape::BadFaces;

// All readers throw SceneError, with the line if known, for missing, empty, truncated or malformed files and for
// indices out of range. With BadFaces::kDrop, faces with vertices out of range are dropped and other indices out of
// range ignored, with a warning. A file without any valid face is still an error. NaN and infinite positions are kept
// (drop_degenerate_triangles() removes triangles that use them). Normals keep their length. A vertex without a usable
// normal has (0, 0, 0) if other vertices have normals; `normals` is empty if none has (compute_vertex_normals() and
// transform_mesh() fill in). Vertices without a texture coordinate get (0, 0); `uvs` is empty if none has one. Polygons
// with more than three corners, convex or concave, are triangulated.

/// Reads Wavefront OBJ. Objects and groups become one mesh. Materials (see scene/formats/obj.h), lines, points and
/// curves are ignored. Corners that share position, normal and texture coordinate share a vertex. `flip_tex_coords`: v
/// becomes 1 - v.
MeshFile read_obj(const std::filesystem::path& file, bool flip_tex_coords, BadFaces bad_faces = BadFaces::kError);

/// Reads Stanford PLY: ASCII and binary in both byte orders, polygons and triangle strips. Texture coordinates are
/// vertex properties u v, s t, texture_u texture_v or texture_s texture_t. A list texcoord with coordinates of the face
/// corners takes precedence; vertices whose corners differ are split. For attributes see
/// scene/formats/ply_attributes.h. Other elements and properties are skipped, with warnings.
MeshFile read_ply(const std::filesystem::path& file, bool flip_tex_coords = false,
                  BadFaces bad_faces = BadFaces::kError);

/// Calls the reader of the shape's format (scene/formats/model_formats.h). A FileCache keeps the result.
MeshFile read_mesh(const MeshFileShape& shape);

/// Estimated peak memory of read_mesh(), in bytes; 0 if the file cannot be read.
double mesh_reading_bytes(const MeshFileShape& shape);

/// Returns the bytes of a regular file, uncompressed if its name ends in .gz. Throws SceneError if it cannot be read;
/// the message names the expected kind of file, `what` ("OBJ file").
std::string read_mesh_bytes(const std::filesystem::path& file, std::string_view what);

/// read_mesh_bytes() for files that start with text: removes a UTF-8 byte order mark. Also throws SceneError for UTF-16
/// and UTF-32 text.
std::string read_mesh_text(const std::filesystem::path& file, std::string_view what);

/// A text file of which threads read parts, so that the whole text is not in memory. Only files whose names end in .gz
/// are read as a whole.
class MeshTextFile {
 public:
  /// Throws the errors of read_mesh_text().
  MeshTextFile(std::filesystem::path file, std::string_view what);

  /// The text has the positions [begin(), end()). It begins after a byte order mark.
  std::size_t begin() const { return begin_; }
  std::size_t end() const { return end_; }
  /// Reads text that begins at `position` and fills `out`; safe to call from any thread. Throws SceneError.
  void read(std::size_t position, std::span<char> out) const;

 private:
  std::filesystem::path file_;
  std::string what_;
  std::string decompressed_;  ///< the text of a compressed file
  std::size_t begin_ = 0, end_ = 0;
};

}  // namespace sheaf

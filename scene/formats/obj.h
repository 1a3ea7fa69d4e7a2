// Wavefront OBJ files with their material assignments.
#pragma once

#include "scene/formats/mesh_io.h"

#include <cstdint>

namespace sheaf {

/// An 'mtllib' line of an OBJ file.
struct ObjLibrary {
  std::string names;  ///< text after the keyword: a file, or several separated by blanks
  SourceLocation where;
};

/// An OBJ file as one mesh, with the materials of its triangles.
struct ObjFile {
  MeshFile file;
  /// Names in order of first use; the empty name is that of faces before any 'usemtl'.
  std::vector<std::string> materials;
  /// Line of the 'usemtl' with which a face first uses each material; 0 without 'usemtl'.
  std::vector<int> material_lines;
  std::vector<std::uint32_t> material_of;  ///< per triangle: index into `materials`
  /// Per triangle: smoothing group, 0 if flat; empty if the file has no groups.
  std::vector<std::uint32_t> smoothing_of;
  std::vector<ObjLibrary> libraries;
};

/// Size of the pieces of a text that threads read independently.
inline constexpr std::size_t kObjPieceBytes = std::size_t{1} << 22;

/// read_obj() with materials; throws the same errors (scene/formats/mesh_io.h). The result does not depend on
/// `piece_bytes`, which must be positive.
ObjFile read_obj_with_materials(const std::filesystem::path& file, bool flip_tex_coords,
                                BadFaces bad_faces = BadFaces::kError, std::size_t piece_bytes = kObjPieceBytes);

}  // namespace sheaf

// Wavefront OBJ files with their material assignments.
#pragma once

#include "scene/formats/mesh_io.h"
#include "scene/formats/obj_lines.h"

#include <cstdint>

namespace sheaf {

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

/// read_obj() with materials; throws the same errors (scene/formats/mesh_io.h).
ObjFile read_obj_with_materials(const std::filesystem::path& file, bool flip_tex_coords,
                                BadFaces bad_faces = BadFaces::kError);

}  // namespace sheaf

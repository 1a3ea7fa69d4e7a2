// Wavefront OBJ files with what they say about materials.
#pragma once

#include "scene/formats/mesh_io.h"
#include "scene/formats/obj_lines.h"

#include <cstdint>

namespace sheaf {

/// An OBJ file as one mesh, and the materials of its triangles.
struct ObjFile {
  MeshFile file;
  std::vector<std::string> materials;      ///< names, in the order of first use; empty: the faces before any 'usemtl'
  std::vector<int> material_lines;         ///< where a face uses each first: the line of 'usemtl'; 0 before any
  std::vector<std::uint32_t> material_of;  ///< per triangle: index into `materials`
  /// Per triangle: smoothing group, 0 if it is flat; empty if the file says nothing of groups.
  std::vector<std::uint32_t> smoothing_of;
  std::vector<ObjLibrary> libraries;
};

/// As read_obj() in scene/formats/mesh_io.h, which throws the same errors.
ObjFile read_obj_with_materials(const std::filesystem::path& file, bool flip_tex_coords,
                                BadFaces bad_faces = BadFaces::kError);

}  // namespace sheaf

// STL meshes, binary and ASCII.
#pragma once

#include "scene/formats/mesh_io.h"

namespace sheaf {

/// Reads STL (3D Systems 1988). Vertices at the same position become one. The normals of the file, which are those of
/// its triangles, are ignored. Throws SceneError.
MeshFile read_stl(const std::filesystem::path& file);

}  // namespace sheaf

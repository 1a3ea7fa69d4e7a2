// Mitsuba's own mesh files, "serialized": several meshes in a file, each deflated.
#pragma once

#include "scene/formats/mesh_io.h"

namespace sheaf {

/// The mesh of index `shape_index`, counted from 0, of a file in the format that the manual of Mitsuba 0.6 describes
/// (versions 3 and 4; single and double precision). Vertex colours become the attribute "vertex_color". Throws
/// SceneError as the other readers of mesh files do, and for an index that the file does not have.
MeshFile read_serialized(const std::filesystem::path& file, int shape_index, BadFaces bad_faces = BadFaces::kError);

}  // namespace sheaf

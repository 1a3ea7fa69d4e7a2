// Mitsuba's "serialized" mesh files: several deflated meshes per file.
#pragma once

#include "scene/formats/mesh_io.h"

namespace sheaf {

/// Reads mesh number `shape_index`, counted from 0, in the format of the Mitsuba 0.6 manual (versions 3 and 4; single
/// and double precision). Vertex colors become the attribute "vertex_color". Throws SceneError as the other mesh
/// readers do, and for an index out of range.
MeshFile read_serialized(const std::filesystem::path& file, int shape_index, BadFaces bad_faces = BadFaces::kError);

}  // namespace sheaf

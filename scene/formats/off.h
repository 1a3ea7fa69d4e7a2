// OFF meshes of Geomview.
#pragma once

#include "scene/formats/mesh_io.h"

namespace sheaf {

/// Reads text files of the Object File Format (Phillips et al., Geomview Manual, "OFF Files"): OFF, COFF, NOFF, STOFF
/// and their combinations, without the prefixes for more dimensions. Colours of vertices and faces become the
/// attributes vertex_color and face_color. Colours are bytes in sRGB if one of them is larger than 1, otherwise linear.
/// Throws SceneError.
MeshFile read_off(const std::filesystem::path& file, BadFaces bad_faces = BadFaces::kError);

}  // namespace sheaf

// PLY files of the most common layout, which all threads read without a copy of the file in memory.
#pragma once

#include "scene/formats/mesh_io.h"

#include <filesystem>
#include <optional>

namespace sheaf {

/// Reads large files with numbers in the byte order of this machine: vertices with properties of type float that the
/// reader uses, then triangles. Returns nothing for all other files, including those with errors.
std::optional<MeshFile> read_plain_ply(const std::filesystem::path& file, bool flip_tex_coords);

}  // namespace sheaf

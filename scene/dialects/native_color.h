// The colour mode of the renderer whose scene format a file has.
#pragma once

#include "core/spectrum.h"

#include <filesystem>

namespace sheaf {

/// Whether the file's name is that of a scene of pbrt: it ends in ".pbrt" or ".pbrt.gz".
bool is_pbrt_scene(const std::filesystem::path& file);

/// Spectral for scenes of pbrt, which knows no other mode; RGB for all others.
ColorMode native_color(const std::filesystem::path& file);

}  // namespace sheaf

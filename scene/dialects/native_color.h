// The color mode of the renderer that a scene file was written for.
#pragma once

#include "core/color/spectrum.h"

#include <filesystem>

namespace sheaf {

/// Whether the file is a pbrt scene: its name ends in ".pbrt" or ".pbrt.gz".
bool is_pbrt_scene(const std::filesystem::path& file);

/// Returns spectral mode for pbrt scenes, because pbrt-v4 is always spectral; RGB mode for all others.
ColorMode native_color(const std::filesystem::path& file);

}  // namespace sheaf

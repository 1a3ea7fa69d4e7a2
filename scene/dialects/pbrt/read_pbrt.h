// Entry point of the pbrt dialect.
#pragma once

#include "scene/content/description.h"

#include <filesystem>

namespace sheaf {

/// Reads a pbrt-v4 scene file, whose relative paths refer to `folder`. If `lenient`, substitutes or drops unsupported
/// features. Throws SceneError.
void read_pbrt(const std::filesystem::path& file, const std::filesystem::path& folder, Description& description,
               bool lenient);

}  // namespace sheaf

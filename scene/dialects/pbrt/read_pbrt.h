// Entry point of the pbrt dialect.
#pragma once

#include "scene/description.h"
#include "scene/description/error_sink.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace sheaf {

/// Reads a pbrt-v4 scene file, whose relative paths refer to `folder`. `defines`: names and values that replace `$name`
/// in words and strings. If `lenient`, substitutes or drops unsupported features. Throws SceneError, also for a define
/// that the scene does not use.
void read_pbrt(const std::filesystem::path& file, const std::filesystem::path& folder, Description& description,
               const std::vector<std::pair<std::string, std::string>>& defines, ErrorSink& errors);

}  // namespace sheaf

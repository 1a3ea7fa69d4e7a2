// Reading a scene file of any dialect.
#pragma once

#include "scene/description/description.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace sheaf {

/// Options of reading.
struct ReadOptions {
  std::vector<std::pair<std::string, std::string>> defines;  ///< -D name=value: what `$name` means in the file
  bool lenient = false;  ///< unknown properties are noted and ignored; unknown plugins stay errors
};

/// Reads a scene file of either dialect, chosen by content: Nori (`camera`, `mesh`, `color`, no version) or Mitsuba 0.6
/// to 3 (`sensor`, `shape`, `version`). Meshes are found, not
/// read, but for OBJ files that bring materials for a shape without one (scene/dialects/obj_materials.h). Throws
/// SceneError.
Description read_scene(const std::filesystem::path& file, const ReadOptions& options = {});

}  // namespace sheaf

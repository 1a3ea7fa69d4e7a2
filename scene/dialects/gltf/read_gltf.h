// Entry point of the glTF dialect.
#pragma once

#include "scene/description.h"
#include "scene/dialects/common/file_contents.h"
#include "scene/dialects/model/model_view.h"

#include <filesystem>
#include <string>

namespace sheaf {

/// The parts of a scene that a glTF file has; without bounds.
struct GltfContents : FileContents {
  bool has_lights = false;
};

/// Reads a glTF 2.0 file (.gltf, .glb): its default scene with its first camera, or the camera that `camera` names.
/// Materials become MetallicRoughnessDescription. Throws SceneError. `lenient`: faces with vertices out of range are
/// dropped. `folder`: see GltfFile.
GltfContents read_gltf(const std::filesystem::path& file, const std::filesystem::path& folder,
                       const AnimationTime& moment, const std::string& camera, bool lenient, Description& description);

}  // namespace sheaf

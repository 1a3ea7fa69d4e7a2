// Choice among the cameras of a scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// Returns the index of the camera with the name or else the number `requested`, counted from 0. Returns 0 if
/// `requested` is empty. Throws SceneError if the scene has no such camera.
std::size_t choose_camera(const std::string& requested, const std::vector<std::string>& names,
                          const std::filesystem::path& file);

}  // namespace sheaf

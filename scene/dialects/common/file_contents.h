// What a scene file contains besides the scene that is read from it, for `sheaf info`.
#pragma once

#include "core/math/vec3d.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

struct FileContents {
  bool has_camera = true;            ///< of its own
  std::vector<std::string> cameras;  ///< names of all cameras, in the order of their numbers, where they have names
  struct Animation {
    std::string name;
    std::optional<std::array<double, 2>> times;  ///< of the first and last key, s; empty: unknown
  };
  std::vector<Animation> animations;
  /// World-space bounds of a model, without surroundings that are added to it; empty for other scenes.
  std::optional<std::array<Vec3d, 2>> model_bounds;
};

}  // namespace sheaf

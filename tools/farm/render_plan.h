// The plan of `sheaf render` for a scene and options, for commands that run it elsewhere.
#pragma once

#include "kernels/render/render_settings.h"

#include <string>
#include <utility>
#include <vector>

namespace sheaf {

struct RenderPlan {
  std::vector<std::string> given;  ///< names of the options given, without dashes
  /// The options of output_options.h that are given or have defaults that depend on the scene, with their values.
  std::vector<std::pair<std::string, std::string>> output_options;
  RenderSettings settings;
};

/// Reads the scene and checks the options, given as the words after `sheaf render`. Throws Error like `sheaf render`
/// does before rendering.
RenderPlan plan_render(const std::vector<std::string>& words);

}  // namespace sheaf

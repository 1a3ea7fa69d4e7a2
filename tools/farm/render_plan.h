// The plan of `sheaf render` for a scene and options, for commands that run it elsewhere.
#pragma once

#include "core/image/pixel_rect.h"
#include "scene/description.h"

#include <string>
#include <utility>
#include <vector>

namespace sheaf {

struct RenderPlan {
  std::vector<std::string> given;  ///< names of the options given, without dashes
  /// The options of output_options.h that are given, with their values.
  std::vector<std::pair<std::string, std::string>> output_options;
  IntegratorKind integrator{};
  PixelRect crop;                 ///< rendered pixels
  std::uint32_t samples = 0;      ///< per pixel
  std::uint32_t gather_rays = 1;  ///< rays that each sample consists of
  std::uint32_t sets = 1;         ///< sets of samples (RenderOptions::replicates)
  bool sets_given = false;        ///< whether the user requested the number of sets
};

/// Reads the scene and checks the options, given as the words after `sheaf render`. Throws Error like `sheaf render`
/// does before rendering. Also prints usage errors of options.
RenderPlan plan_render(const std::vector<std::string>& words);

}  // namespace sheaf

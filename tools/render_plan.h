// What `sheaf render` would do with a scene and options, for commands that have it done elsewhere.
#pragma once

#include "core/pixel_rect.h"
#include "scene/description/description.h"

#include <string>
#include <vector>

namespace sheaf {

struct RenderPlan {
  std::vector<std::string> given;  ///< options that are given, without dashes
  IntegratorKind integrator = IntegratorKind::kPath;
  PixelRect crop;                 ///< pixels that are rendered
  std::uint32_t samples = 0;      ///< per pixel
  std::uint32_t gather_rays = 1;  ///< that each of them is made of
  std::uint32_t sets = 1;         ///< into which they would be cut (RenderOptions::replicates)
  bool sets_given = false;        ///< and these are asked for
};

/// Reads the scene and checks the options; `words` are those behind `sheaf render`. Throws Error as render does before
/// it begins; a usage error of an option is printed as well.
RenderPlan plan_render(const std::vector<std::string>& words);

}  // namespace sheaf

// Whether a render uses path guiding.
#pragma once

#include "scene/tables/render_settings.h"

namespace sheaf {

/// Whether camera paths sample directions from a trained guide.
enum class GuidingMode {
  kOff,
  kOn,
  kAuto,  ///< if it is worth its cost, see guiding_gain()
};

/// Whether the integrator has paths that can sample a guide.
inline bool can_guide(const IntegratorSettings& integrator) {
  return integrator.traits().supports_guiding && !integrator.ends_at_diffuse;
}

/// Whether a render trains a guide. With kAuto only for indirect light: direct light is sampled at the lights.
inline bool trains_guide(GuidingMode mode, const IntegratorSettings& integrator) {
  const bool has_indirect_light = integrator.max_depth < 0 || integrator.max_depth > 2;
  return mode == GuidingMode::kOn || (mode == GuidingMode::kAuto && can_guide(integrator) && has_indirect_light);
}

}  // namespace sheaf

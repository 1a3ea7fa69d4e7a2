// Names of medium estimators, shared by all dialects and the command line, and the integrator properties that control
// distance sampling and transmittance estimation in media.
#pragma once

#include "scene/xml/properties.h"

#include <string_view>

namespace sheaf {

/// Returns the estimator `null_mis`, `delta`, `ratio` or `marching`; nullopt for other names.
std::optional<MediumEstimator> find_medium_estimator(std::string_view name);

/// Returns all estimator names.
std::vector<std::string> medium_estimator_names();

/// Returns the name of an estimator.
const char* medium_estimator_name(MediumEstimator estimator);

/// Returns the estimator of this name. Throws Error (usage) for an unknown name; the message lists the nearest name and
/// all names.
MediumEstimator medium_estimator_from_name(std::string_view name);

/// Reads `medium_estimator` (a name) and `step_size` (m, positive). Throws SceneError.
void read_medium_estimation(Properties& p, IntegratorSettings& integrator);

}  // namespace sheaf

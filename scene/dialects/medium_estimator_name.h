// The names of medium estimators, in all dialects and on the command line, and the properties of integrators that say
// how distances in media and transmittance are estimated.
#pragma once

#include "scene/xml/properties.h"

#include <string_view>

namespace sheaf {

/// The estimator called null_mis, delta, ratio or marching; nothing for other names.
std::optional<MediumEstimator> find_medium_estimator(std::string_view name);

/// All names.
std::vector<std::string> medium_estimator_names();

/// The name of an estimator.
const char* medium_estimator_name(MediumEstimator estimator);

/// The estimator of this name. Throws Error (usage) for an unknown one, with the nearest known one and all others.
MediumEstimator medium_estimator_from_name(std::string_view name);

/// Reads `medium_estimator` (a name) and `step_size` (metres, positive). Throws SceneError.
void read_medium_estimation(Properties& p, IntegratorDescription& integrator);

}  // namespace sheaf

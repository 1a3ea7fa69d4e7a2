// Names of medium estimators, shared by all dialects and the command line, and the integrator properties that control
// distance sampling and transmittance estimation in media.
#pragma once

#include "scene/content/description.h"
#include "scene/xml/named_values.h"

namespace sheaf {

inline constexpr NameTable<MediumEstimator> kMediumEstimators{{{"null_mis", MediumEstimator::kNullMis},
                                                               {"delta", MediumEstimator::kDelta},
                                                               {"ratio", MediumEstimator::kRatio},
                                                               {"marching", MediumEstimator::kMarching}}};

/// Reads `medium_estimator` (a name) and `step_size` (m, positive). Throws SceneError.
void read_medium_estimation(NamedValues& p, IntegratorSettings& integrator);

}  // namespace sheaf

// Properties of integrators that control distance sampling and transmittance estimation in media.
#include "scene/dialects/common/medium_estimator_name.h"

namespace sheaf {

void read_medium_estimation(NamedValues& p, IntegratorSettings& integrator) {
  integrator.step_size = p.number("step_size", integrator.step_size, kPositive);
  integrator.medium_estimator = p.choice("medium_estimator", kMediumEstimators, integrator.medium_estimator);
}

}  // namespace sheaf

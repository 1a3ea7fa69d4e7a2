// Properties of integrators that control light sampling.
#include "scene/dialects/common/light_selector_name.h"

namespace sheaf {

void read_light_sampling(NamedValues& p, IntegratorSettings& integrator) {
  integrator.sets_candidates = integrator.sets_candidates || p.has("candidates");
  integrator.candidates = p.integer("candidates", integrator.candidates, 1, kMaxCandidates);
  integrator.light_selector = p.choice("light_sampler", kLightSelectors, integrator.light_selector);
}

}  // namespace sheaf

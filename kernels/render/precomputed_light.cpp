#include "kernels/render/precomputed_light.h"

#include <algorithm>

namespace sheaf {

PrecomputedLight::PrecomputedLight(StageContext& context, const SamplePlan& plan, GuidingMode guiding,
                                   ProgressReporter& reporter)
    : photon_tracing_{[&reporter] { return reporter.is_stopped(); },
                      [&reporter](std::uint64_t more) { reporter.add_done(more); }},
      guiding_(guiding),
      candidates_{context.candidates, {}},
      guide_training_{[&reporter] { return reporter.is_stopped(); },
                      [&reporter](std::uint64_t more) { reporter.add_done(more); }} {
  const Film& film = plan.state().film;
  if (context.integrator.traits().has_photon_maps())
    photon_mapping_.emplace(context, plan.layout().spp, std::max(film.width(), film.height()));
  // Waves allocate what guided paths need, even if training rejects the guide.
  if (trains_guide(guiding, context.integrator) && !plan.training().empty()) context.sample_from(guide_.view());
}

void PrecomputedLight::train(const SamplePlan& plan, Workers& workers, StageContext& context) {
  const Film& film = plan.state().film;
  guide_ = train_guide(context, workers, film.width(), film.height(), plan.training(), guiding_,
                       plan.has_candidate_trial(), guide_training_);
  if (plan.has_candidate_trial()) {
    context.candidates = guide_training_.candidates.count;
    const CandidateChoice& choice = guide_training_.candidates;
    candidates_ = {choice.count, {choice.gains.begin(), choice.gains.end()}};
  }
  if (guide_training_.report.is_used)
    context.sample_from(guide_.view());
  else
    context.sample_bsdfs_only();
}

void PrecomputedLight::prepare(std::uint32_t sample, Workers& workers, StageContext& context) {
  if (photon_mapping_) photon_mapping_->prepare(sample, workers, photon_tracing_, context);
}

}  // namespace sheaf

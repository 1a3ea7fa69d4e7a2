#include "kernels/render/precomputed_light.h"

#include <algorithm>

namespace sheaf {

PrecomputedLight::PrecomputedLight(StageContext& context, const RenderSettings& settings, ProgressReporter& reporter)
    : photon_tracing_{[&reporter] { return reporter.is_stopped(); },
                      [&reporter](std::uint64_t more) { reporter.add_done(more); }},
      candidates_{context.candidates, {}},
      guide_training_{[&reporter] { return reporter.is_stopped(); },
                      [&reporter](std::uint64_t more) { reporter.add_done(more); }} {
  if (context.integrator.traits().has_photon_maps())
    photon_mapping_.emplace(context, settings.spp, std::max(settings.film.width, settings.film.height));
  // Waves allocate what guided paths need, even if training rejects the guide.
  if (!settings.training.empty()) context.sample_from(guide_.view());
}

void PrecomputedLight::train(const RenderSettings& settings, Workers& workers, StageContext& context) {
  guide_ = train_guide(context, workers, settings.film.width, settings.film.height, settings.training, settings.guiding,
                       settings.compares_candidates, guide_training_);
  if (settings.compares_candidates) {
    const CandidateChoice& choice = guide_training_.candidates;
    context.candidates = choice.count;
    candidates_ = {context.candidates, {choice.gains.begin(), choice.gains.end()}};
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

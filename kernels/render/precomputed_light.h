// Light that is traced before the camera samples that use it: photon maps, and the guide.
#pragma once

#include "kernels/passes/photon_mapping.h"
#include "kernels/render/progress_reporter.h"
#include "kernels/training/train_guiding.h"

namespace sheaf {

class PrecomputedLight {
 public:
  /// For the camera passes of `context`.
  PrecomputedLight(StageContext& context, const RenderSettings& settings, ProgressReporter& reporter);

  /// Trains the guide for the following samples of `context`. With GuidingMode::kAuto, these sample it only if it is
  /// worth its cost. Sets their number of light candidates, if the passes compare them.
  void train(const RenderSettings& settings, Workers& workers, StageContext& context);
  /// Builds the photon maps for the next samples of `context`, if the integrator uses photon maps. `sample`: the first.
  void prepare(std::uint32_t sample, Workers& workers, StageContext& context);

  /// Number of photons that all maps of the render store, for progress.
  std::uint64_t photon_total() const { return photon_mapping_ ? photon_mapping_->photon_total() : 0; }
  const RenderReport::Photons& photons() const { return photon_tracing_.report; }
  const RenderReport::Guiding& guiding() const { return guide_training_.report; }
  const RenderReport::Candidates& candidates() const { return candidates_; }
  /// About photon maps that hold fewer photons than requested.
  const std::vector<std::string>& warnings() const { return photon_tracing_.warnings; }

 private:
  std::optional<PhotonMapping> photon_mapping_;
  PhotonTracing photon_tracing_;
  RenderReport::Candidates candidates_;
  GuideField guide_;
  GuideTraining guide_training_;
};

}  // namespace sheaf

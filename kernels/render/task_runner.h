// Runs the tasks of a sample plan on the threads of a render.
#pragma once

#include "kernels/caustics/casters.h"
#include "kernels/passes/worker.h"
#include "kernels/render/precomputed_light.h"
#include "kernels/render/progress_reporter.h"
#include "kernels/render/render_memory.h"
#include "kernels/render/sample_plan.h"

namespace sheaf {

class TaskRunner {
 public:
  /// All arguments must outlive the runner.
  TaskRunner(const Scene& scene, const RenderControl& control, SamplePlan& plan, ProgressReporter& reporter);

  /// Runs rounds of tasks until no samples remain, the render is stopped or the time limit is reached.
  void run();
  /// Statistics of the tasks so far. Must not be called while workers run.
  TaskStatistics statistics() const {
    return {workers_, threads_, wave_.size, light_.photons(), light_.guiding(), light_.candidates()};
  }
  /// Warnings of the tasks so far.
  const std::vector<std::string>& warnings() const { return light_.warnings(); }

 private:
  bool ends() const { return reporter_.is_stopped() || (plan_.may_end_early() && reporter_.is_late()); }
  void run_round();
  void run_tasks();
  void run_task(std::size_t index);
  void take_samples(const TileTask& task, Worker& worker) const;
  void take_samples(const TileTask& task, std::uint32_t first_sample, std::uint32_t sample_count, Worker& worker) const;
  void trace_photons(const PhotonTask& task, Worker& worker) const;
  std::optional<LightGroupSink> group_sink(CameraTask& task) const;

  const RenderControl& control_;
  SamplePlan& plan_;
  ProgressReporter& reporter_;
  std::optional<CausticCasters> casters_;  ///< CausticMode::kManifold, if there are any
  StageContext context_;                   ///< of camera rounds
  PrecomputedLight light_;
  int threads_;
  WaveSetup wave_;
  Workers workers_;
};

}  // namespace sheaf

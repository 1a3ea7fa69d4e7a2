// Connection between a running render and its caller: passes on progress, reports and checkpoints, and checks for pause
// requests, stop requests and the time limit.
#pragma once

#include "kernels/passes/render_report.h"
#include "kernels/passes/worker.h"
#include "kernels/render/render.h"
#include "kernels/render/sample_plan.h"

#include <atomic>
#include <chrono>

namespace sheaf {

/// Additions of tasks to a report, besides the samples.
struct TaskStatistics {
  const Workers& workers;
  int threads, wave_size;
  RenderReport::Photons photons;
  RenderReport::Guiding guiding;
  RenderReport::Candidates candidates;
};

class ProgressReporter {
 public:
  /// Starts the clock. All arguments must outlive the reporter.
  ProgressReporter(const Scene& scene, const RenderControl& control, const SamplePlan& plan)
      : scene_(scene), settings_(plan.settings()), control_(control), before_(plan.samples_before()) {}

  /// Whether RenderControl::stop ends the render.
  bool is_stopped() const { return control_.stop != nullptr && control_.stop->load(std::memory_order_relaxed); }
  /// Whether the time limit is reached.
  bool is_late() const { return settings_.time_limit > 0 && seconds() >= settings_.time_limit; }
  /// Polls RenderControl::wants_pause. Once it is true, workers must not start tasks until the pause.
  bool wants_pause();
  /// Result of the last wants_pause().
  bool is_pausing() const { return pausing_; }

  /// Sets the number of samples and photons of the whole render, and the number that is taken regardless of a time
  /// limit. `is_bound`: see RenderProgress. Must not be called while workers run.
  void set_total(std::uint64_t total, std::uint64_t min_total, bool is_bound) {
    total_ = total;
    min_total_ = min_total;
    is_bound_ = is_bound;
  }
  /// Reports more samples or photons as progress. Workers call it concurrently.
  void add_done(std::uint64_t more);
  /// Passes the statistics and a checkpoint to the caller. All workers must have finished their tasks.
  void pause(SamplePlan& plan, const TaskStatistics& tasks);
  /// The report without the noise of the image. Adds to `warnings`.
  RenderReport report(const SamplePlan& plan, const TaskStatistics& tasks, std::vector<std::string>& warnings) const;

 private:
  double seconds() const;

  const Scene& scene_;
  const RenderSettings& settings_;
  const RenderControl& control_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::atomic<bool> pausing_{false};
  const std::uint64_t before_;
  std::uint64_t total_ = 0, min_total_ = 0;
  bool is_bound_ = false;
  std::atomic<std::uint64_t> done_{before_};
};

}  // namespace sheaf

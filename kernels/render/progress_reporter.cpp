// Calls the callbacks of RenderControl, and collects the report.
#include "kernels/render/progress_reporter.h"

#include "core/simd/saturate.h"
#include "kernels/render/worker_report.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Dropped rays and samples of this render and of those that it resumes.
Stats::Dropped dropped_so_far(const SamplePlan& plan, const Workers& workers) {
  Stats::Dropped all = plan.dropped_before();
  for (const Worker& worker : workers) {
    all.rays += worker.wave.stats.dropped.rays;
    all.samples += worker.wave.stats.dropped.samples;
  }
  return all;
}

/// Sets the sample counts of the report to the samples taken so far.
void add_samples(const SamplePlan& plan, RenderReport& report) {
  const RenderState& state = plan.state();
  report.spp = plan.settings().spp;
  report.mean_samples = state.film.mean_samples();
  if (state.adaptive) {
    report.adaptive = state.adaptive->summary();
    report.mean_samples = report.adaptive->mean_samples;
    report.spp = saturate<std::uint32_t>(std::round(report.mean_samples));
  }
  if (state.splats)
    report.mean_samples =
        static_cast<double>(state.photons) / (static_cast<double>(state.film.width()) * state.film.height());
}

}  // namespace

bool ProgressReporter::wants_pause() {
  if (!pausing_ && control_.wants_pause && control_.wants_pause()) pausing_ = true;
  return pausing_;
}

void ProgressReporter::add_done(std::uint64_t more) {
  const std::uint64_t done = done_.fetch_add(more, std::memory_order_relaxed) + more;
  if (!control_.on_progress) return;
  RenderProgress progress{done, total_, before_, is_bound_};
  if (settings_.time_limit > 0) {
    const double elapsed = seconds(), left = std::max(settings_.time_limit - elapsed, 0.0);
    const auto at_limit = done + static_cast<std::uint64_t>(left * progress.samples_per_second(elapsed));
    progress.total = std::min(total_, std::max(at_limit, min_total_));
    if (at_limit >= min_total_) progress.until_limit = left;
  }
  control_.on_progress(progress);
}

void ProgressReporter::pause(SamplePlan& plan, const TaskStatistics& tasks) {
  pausing_ = false;
  if (control_.on_report) {
    std::vector<std::string> warnings;
    control_.on_report(report(plan, tasks, warnings));
  }
  if (control_.on_pause) control_.on_pause(plan.checkpoint(dropped_so_far(plan, tasks.workers)));
}

RenderReport ProgressReporter::report(const SamplePlan& plan, const TaskStatistics& tasks,
                                      std::vector<std::string>& warnings) const {
  RenderReport report;
  report.integrator = settings_.integrator.name();
  report.isa = kIsaName;
  report.width = plan.state().film.width();
  report.height = plan.state().film.height();
  report.seed = settings_.sampler.seed;
  report.threads = tasks.threads;
  report.wave_size = tasks.wave_size;
  report.render_seconds = seconds();
  add_samples(plan, report);
  report.photons = tasks.photons;
  report.guiding = tasks.guiding;
  report.candidates = tasks.candidates;
  add_workers(tasks.workers, plan.settings().frame, dropped_so_far(plan, tasks.workers), report, warnings);
  for (const SourceLocation& position : scene_.light_source_locations())
    report.light_source_locations.push_back(
        position.line > 0 ? fmt::format("{}:{}", position.file.string(), position.line) : std::string());
  return report;
}

double ProgressReporter::seconds() const {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  return elapsed.count();
}

}  // namespace sheaf

// Runs a pass by the schedule of kernels/stages/stage_list.h.
#include "kernels/passes/passes.h"
#include "kernels/photons/light_task.h"
#include "kernels/stages/stage_list.h"

#include <cassert>
#include <vector>

namespace sheaf {

namespace {

/// The stages of one pass in order, without those that take no part. Stages that run once per light candidate are
/// repeated.
template <class L> class Schedule {
 public:
  explicit Schedule(const StageContext& context) {
    for (const StageEntry& stage : kStages<L>) {
      if (!stage.takes_part(context)) continue;
      if (stage.is_source()) {
        source_ = stage.run;
      } else if (stage.run_candidate != nullptr) {
        candidate_stages_.push_back(stage.run_candidate);
      } else {
        repeat_candidate_stages(context.candidates);
        steps_.push_back({stage.run, nullptr, 0});
      }
    }
    repeat_candidate_stages(context.candidates);
  }

  /// Starts paths in free slots.
  void start_paths(const StageContext& context, Wave& wave) const { source_(context, wave); }

  /// Runs every other stage once.
  void advance_paths(const StageContext& context, Wave& wave) const {
    for (const Step& step : steps_) {
      if (step.run != nullptr)
        step.run(context, wave);
      else
        step.run_candidate(context, wave, step.candidate);
    }
  }

 private:
  struct Step {
    decltype(StageEntry::run) run;
    decltype(StageEntry::run_candidate) run_candidate;
    int candidate;
  };

  /// Appends the stages collected in candidate_stages_ once for each candidate.
  void repeat_candidate_stages(int candidates) {
    for (int candidate = 0; candidate < candidates; ++candidate)
      for (const auto run : candidate_stages_) steps_.push_back({nullptr, run, candidate});
    candidate_stages_.clear();
  }

  decltype(StageEntry::run) source_ = nullptr;
  std::vector<Step> steps_;
  std::vector<decltype(StageEntry::run_candidate)> candidate_stages_;
};

/// Whether the source has paths left to start. Camera rays never fail to start, photons may.
bool has_paths_left(const StageContext& context) {
  return context.starts_at_lights() && context.light_task().left() > 0;
}

}  // namespace

template <class L> void run_pass(const StageContext& context, Wave& wave) {
  const Schedule<L> schedule(context);
  for (;;) {
    // Refill when half empty: fewer, fuller calls.
    if (2 * wave.free.size() >= wave.capacity) schedule.start_paths(context, wave);
    if (wave.active.empty() && !has_paths_left(context)) break;
    schedule.advance_paths(context, wave);
    assert(wave.free.size() + wave.active.size() == wave.capacity);
  }
}

template void run_pass<SHEAF_STAGE_LANE>(const StageContext&, Wave&);

}  // namespace sheaf

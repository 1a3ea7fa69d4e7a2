// Collects the statistics of workers and formats the warnings.
#include "kernels/render/worker_report.h"

#include "core/io/memory.h"
#include "kernels/media/medium_tracking.h"
#include "kernels/stages/stage_list.h"

namespace sheaf {

namespace {

std::string dropped_message(const Stats::Dropped& dropped, const Wave::Dropped& first, const SampledFrame& frame) {
  const std::string what = fmt::format(
      "dropped {} non-finite rays and {} non-finite or negative samples; the first: ", dropped.rays, dropped.samples);
  if (first.pixel >= kPhotonPixel)
    return fmt::format("{}photon {}", what, std::uint64_t{first.pixel - kPhotonPixel} << 32 | first.sample);
  return fmt::format("{}pixel ({}, {}), sample {}", what, frame.x(first.pixel), frame.y(first.pixel), first.sample);
}

}  // namespace

void add_workers(const Workers& workers, const SampledFrame& frame, const Stats::Dropped& dropped, RenderReport& report,
                 std::vector<std::string>& warnings) {
  for (const StageEntry& stage : kStages<Wide>) report.stage_names.push_back(stage.name);
  const Wave::Dropped* first = nullptr;
  for (const Worker& worker : workers) {
    report.stats += worker.wave.stats;
    const Wave::Dropped& each = worker.wave.first_dropped;
    if (each.any && (!first || each.pixel < first->pixel)) first = &each;
  }
  report.peak_rss_bytes = peak_rss_bytes();
  report.peak_private_bytes = peak_private_bytes();
  report.stats.dropped = dropped;
  if (first) warnings.push_back(dropped_message(dropped, *first, frame));
  if (const std::uint64_t abandoned = report.stats.collisions.abandoned; abandoned > 0)
    warnings.push_back(fmt::format(
        "{} rays were abandoned in a medium after {} collisions each: the range of its voxel values is too large",
        abandoned, kMaxCollisions));
}

}  // namespace sheaf

// Collects the statistics of workers and formats the warnings.
#include "kernels/render/worker_report.h"

#include "core/io/memory.h"
#include "kernels/media/medium_tracking.h"
#include "kernels/stages/stage_list.h"

namespace sheaf {

namespace {

std::string dropped_message(const Stats::Dropped& dropped, const Wave::Dropped& first, const SampledFrame& frame) {
  const std::string what = "dropped " + std::to_string(dropped.rays) + " non-finite rays and " +
                           std::to_string(dropped.samples) + " non-finite or negative samples; the first: ";
  if (first.pixel >= kPhotonPixel)
    return what + "photon " + std::to_string(std::uint64_t{first.pixel - kPhotonPixel} << 32 | first.sample);
  return what + "pixel (" + std::to_string(frame.x(first.pixel)) + ", " + std::to_string(frame.y(first.pixel)) +
         "), sample " + std::to_string(first.sample);
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
    warnings.push_back(std::to_string(abandoned) + " rays were abandoned in a medium after " +
                       std::to_string(kMaxCollisions) + " collisions each: the range of its voxel values is too large");
}

}  // namespace sheaf

#include "kernels/passes/trace_photons.h"

#include "kernels/passes/passes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Tasks of the smallest maps. How many are traced before their photons are counted is for the threads to say.
constexpr std::uint64_t kFewestTasks = 64;
/// Photons emitted for each one asked for, and more for small maps, until it is taken for sure that hardly any arrive.
constexpr std::uint64_t kMostPerStored = 64, kMostMore = 1 << 20;
/// First numbers of photons, so that maps share no random numbers.
constexpr std::uint64_t first_photon(PhotonKind kind) {
  return kind == PhotonKind::kGlobal ? 0 : std::uint64_t{1} << 48;
}

const char* name_of(PhotonKind kind) { return kind == PhotonKind::kGlobal ? "photon map" : "caustics map"; }

/// The next tasks' photons, each task's in order.
std::vector<std::vector<Photon>> trace_round(const StageContext& camera, Workers& workers, PhotonKind kind,
                                             std::uint64_t first, int task_photons, const PhotonTracing& tracing) {
  std::vector<std::vector<Photon>> stored(4 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, stored.size(), 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end() && !tracing.stopped(); ++i) {
          const FlushDenormals flush;
          Worker& worker = workers.local();
          worker.photons.begin(first + i * static_cast<std::uint64_t>(task_photons), task_photons, kind);
          StageContext context = camera;
          context.camera = nullptr;
          context.maps = nullptr;
          context.photons = &worker.photons;
          run_photon_pass<Wide>(context, worker.wave);
          worker.photons.sort_stored();
          stored[i] = worker.photons.stored;
        }
      },
      tbb::simple_partitioner());
  return stored;
}

}  // namespace

PhotonMap trace_photons(const StageContext& context, Workers& workers, const PhotonMapDescription& description,
                        PhotonKind kind, PhotonKernel kernel, PhotonTracing& tracing) {
  const std::uint64_t wanted = description.count;
  const int task_photons = static_cast<int>(std::clamp<std::uint64_t>(wanted / kFewestTasks, 64, 16384));
  std::vector<std::vector<Photon>> tasks;
  std::uint64_t stored = 0, emitted = 0;
  const std::uint64_t most = kMostPerStored * wanted + kMostMore;
  while (stored < wanted && emitted < most && context.scene.light_count > 0 && !tracing.stopped()) {
    auto round = trace_round(context, workers, kind, first_photon(kind) + emitted, task_photons, tracing);
    const std::uint64_t before = stored;
    // Whole tasks, so that the number of photons emitted is known.
    for (std::size_t i = 0; i < round.size() && stored < wanted; ++i) {
      stored += round[i].size();
      emitted += static_cast<std::uint64_t>(task_photons);
      tasks.push_back(std::move(round[i]));
    }
    tracing.on_stored(std::min(stored, wanted) - std::min(before, wanted));
  }
  if (stored < wanted && !tracing.stopped()) {
    tracing.warnings.push_back("the " + std::string(name_of(kind)) + " holds " + std::to_string(stored) + " of the " +
                               std::to_string(wanted) + " photons that were asked for: of " + std::to_string(emitted) +
                               " emitted ones no more arrive where they are stored");
    tracing.on_stored(wanted - stored);
  }
  tracing.emitted += emitted;
  const float radius =
      description.radius > 0.0f ? description.radius : description.relative_radius * context.scene.radius;
  return PhotonMap(std::move(tasks), std::max<std::uint64_t>(emitted, 1), radius, kernel);
}

}  // namespace sheaf

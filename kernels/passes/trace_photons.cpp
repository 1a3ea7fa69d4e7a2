#include "kernels/passes/trace_photons.h"

#include "kernels/passes/passes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Tasks of the smallest maps.
constexpr std::uint64_t kFewestTasks = 64;
/// Photons emitted for each one asked for, and more for small maps, until it is taken for sure that hardly any arrive.
constexpr std::uint64_t kMostPerStored = 64, kMostMore = 1 << 20;
/// Which map of a set photons of a kind are in.
int map_of(PhotonKind kind) { return kind == PhotonKind::kCaustic ? 1 : kind == PhotonKind::kVolume ? 2 : 0; }

/// First numbers of photons, so that maps share no random numbers: more than kMostPerStored * kMaxPhotons apart.
std::uint64_t first_photon(const PhotonRequest& request) {
  constexpr int kMapBits = 37, kSetBits = 40;
  return std::uint64_t{request.set} << kSetBits | static_cast<std::uint64_t>(map_of(request.kind)) << kMapBits;
}

/// Longest piece into which beams are cut, over the radius of the scene's bounding sphere.
constexpr float kPieceOfScene = 0.125f;

constexpr const char* kMapNames[] = {"photon map", "caustics map", "volume photon map"};

/// What one task has stored.
struct StoredPhotons {
  std::vector<Photon> photons;
  std::vector<PhotonBeam> beams;
  std::uint64_t counted = 0;  ///< towards the number that is asked for
};

/// The next tasks' photons, each task's in order.
std::vector<StoredPhotons> trace_round(const StageContext& camera, Workers& workers, PhotonKind kind,
                                       std::uint64_t first, int task_photons, std::size_t tasks,
                                       const PhotonTracing& tracing) {
  std::vector<StoredPhotons> stored(tasks);
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
          context.sampler = without_frame(context.sampler);
          run_photon_pass<Wide>(context, worker.wave);
          stored[i].photons = worker.photons.sorted_photons();
          stored[i].beams = worker.photons.sorted_beams();
          stored[i].counted =
              map_of(kind) == 0 ? worker.photons.arrived : stored[i].photons.size() + stored[i].beams.size();
        }
      },
      tbb::simple_partitioner());
  return stored;
}

/// How many tasks are traced before their photons are counted: a few for each thread; once it is known what a task
/// stores, as many as are still needed.
std::size_t round_size(std::size_t done, std::uint64_t stored, std::uint64_t wanted) {
  const auto threads = static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
  if (stored == 0) return 4 * threads;
  const std::uint64_t needed = (wanted - stored) * done / stored + 1;
  return std::min(needed, 64 * threads);
}

/// Tasks' photons until enough are stored, and how many were emitted for them; at least 1.
struct TracedPhotons {
  std::vector<std::vector<Photon>> tasks;
  std::vector<std::vector<PhotonBeam>> beams;
  std::uint64_t emitted = 0;
};

TracedPhotons trace(const StageContext& context, Workers& workers, const PhotonRequest& request,
                    PhotonTracing& tracing) {
  const std::uint64_t start = timestamp(), wanted = request.count;
  const int task_photons = static_cast<int>(std::clamp<std::uint64_t>(wanted / kFewestTasks, 64, 16384));
  TracedPhotons out;
  std::uint64_t stored = 0;
  // Once it is known that hardly any arrive, it is not tried that hard again.
  bool& scarce = tracing.scarce[map_of(request.kind)];
  const std::uint64_t most = scarce ? wanted : kMostPerStored * wanted + kMostMore;
  const auto hopeless = [&] { return out.emitted >= most || (stored == 0 && out.emitted >= kMostMore); };
  while (stored < wanted && !hopeless() && context.scene.light_count > 0 && !tracing.stopped()) {
    auto round = trace_round(context, workers, request.kind, first_photon(request) + out.emitted, task_photons,
                             round_size(out.tasks.size(), stored, wanted), tracing);
    const std::uint64_t before = stored;
    // Whole tasks, so that the number of photons emitted is known.
    for (std::size_t i = 0; i < round.size() && stored < wanted; ++i) {
      stored += round[i].counted;
      out.emitted += static_cast<std::uint64_t>(task_photons);
      out.tasks.push_back(std::move(round[i].photons));
      out.beams.push_back(std::move(round[i].beams));
    }
    tracing.on_stored(std::min(stored, wanted) - std::min(before, wanted));
  }
  if (stored < wanted && !tracing.stopped()) {
    if (!scarce)
      tracing.warnings.push_back("the " + std::string(kMapNames[map_of(request.kind)]) + " holds " +
                                 std::to_string(stored) + " of the " + std::to_string(wanted) +
                                 " photons that were asked for: of " + std::to_string(out.emitted) +
                                 " emitted ones no more arrive where they are stored");
    scarce = true;
    tracing.on_stored(wanted - stored);
  }
  tracing.report.emitted += out.emitted;
  for (const std::vector<Photon>& task : out.tasks) tracing.report.stored += task.size();
  for (const std::vector<PhotonBeam>& task : out.beams) tracing.report.stored += task.size();
  tracing.report.trace_seconds += seconds_since(start);
  out.emitted = std::max<std::uint64_t>(out.emitted, 1);
  return out;
}

}  // namespace

PhotonMap trace_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                        PhotonTracing& tracing) {
  TracedPhotons traced = trace(context, workers, request, tracing);
  const std::uint64_t start = timestamp();
  const PhotonMappingDescription& settings = context.transport.photons;
  PhotonMap map(std::move(traced.tasks), traced.emitted, request.radius, settings.kernel, settings.lookup_size,
                context.scene.color == ColorMode::kSpectral);
  tracing.report.index_seconds += seconds_since(start);
  return map;
}

VolumePhotonMaps trace_volume_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                                      PhotonTracing& tracing) {
  TracedPhotons traced = trace(context, workers, request, tracing);
  const std::uint64_t start = timestamp();
  const PhotonKernel kernel = context.transport.photons.kernel;
  VolumePhotonMaps map{{std::move(traced.tasks), traced.emitted, request.radius, kernel}, {}};
  if (context.transport.photons.uses_beams())
    map.beams = {traced.beams, traced.emitted, request.beam_radius, kPieceOfScene * context.scene.radius, kernel};
  tracing.report.index_seconds += seconds_since(start);
  return map;
}

}  // namespace sheaf

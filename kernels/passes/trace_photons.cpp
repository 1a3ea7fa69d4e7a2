// Runs photon passes in parallel tasks, and builds maps from the photons in the order of tasks.
#include "kernels/passes/trace_photons.h"

#include "core/simd/flush_denormals.h"
#include "kernels/passes/passes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Range of photons per task, and the minimum number of tasks of small maps.
constexpr std::uint64_t kMinTaskPhotons = 64, kMaxTaskPhotons = 16384, kMinTasks = 64;
/// The probe emits kMinProbePhotons, then doubles the total until it has stored kProbeStoredPhotons photons, which
/// gives the rate within a few percent, or has emitted kMaxProbePhotons.
constexpr std::uint64_t kMinProbePhotons = 4096, kMaxProbePhotons = 1 << 18, kProbeStoredPhotons = 2048;
/// Index of the map of a set that holds photons of a kind.
int map_of(PhotonKind kind) { return kind == PhotonKind::kCaustic ? 1 : kind == PhotonKind::kVolume ? 2 : 0; }

/// Index of the first photon of a map, such that maps share no random numbers. The set of the probe is kMaxPhotonSets.
std::uint64_t first_photon(PhotonKind kind, std::uint32_t set) {
  constexpr int kMapBits = 37, kSetBits = 40;
  return std::uint64_t{set} << kSetBits | static_cast<std::uint64_t>(map_of(kind)) << kMapBits;
}

/// Maximum length of the pieces into which beams are cut, relative to the radius of the scene's bounding sphere.
constexpr float kMaxBeamSegment = 0.125f;

constexpr const char* kMapNames[] = {"photon map", "caustic map", "volume photon map"};

/// Photons stored by one task.
struct StoredPhotons {
  std::vector<Photon> photons;
  std::vector<PhotonBeam> beams;
  std::uint64_t counted = 0;  ///< photons that count towards the requested number
};

/// Traces photons [first, first + count) in tasks. Returns the photons of each task in order.
std::vector<StoredPhotons> trace_tasks(const StageContext& camera, Workers& workers, PhotonKind kind,
                                       std::uint64_t first, std::uint64_t count, PhotonTracing& tracing,
                                       std::uint64_t expected) {
  const std::uint64_t task_photons = std::clamp(count / kMinTasks, kMinTaskPhotons, kMaxTaskPhotons);
  const std::uint64_t tasks = (count + task_photons - 1) / task_photons;
  std::vector<StoredPhotons> stored(tasks);
  const auto progress = [&](std::uint64_t done) { return expected * done / tasks; };
  tbb::parallel_for(
      tbb::blocked_range<std::uint64_t>(0, tasks, 1),
      [&](const tbb::blocked_range<std::uint64_t>& range) {
        for (std::uint64_t i = range.begin(); i < range.end() && !tracing.stopped(); ++i) {
          const FlushDenormals flush;
          Worker& worker = workers.local();
          const std::uint64_t before = i * task_photons;
          worker.photons.begin(first + before, static_cast<int>(std::min(task_photons, count - before)), kind);
          StageContext context = camera;
          context.start_at_lights(PassKind::kPhoton, worker.photons);
          context.sampler = without_frame(context.sampler);
          run_pass<Wide>(context, worker.wave);
          stored[i].photons = worker.photons.sorted_photons();
          stored[i].beams = worker.photons.sorted_beams();
          stored[i].counted =
              map_of(kind) == 0 ? worker.photons.arrived : stored[i].photons.size() + stored[i].beams.size();
          tracing.on_stored(progress(i + 1) - progress(i));
        }
      },
      tbb::simple_partitioner());
  return stored;
}

/// Numbers of photons that the probe has emitted and stored.
struct PhotonCounts {
  std::uint64_t emitted = 0, stored = 0;
};

PhotonCounts estimate_storing_rate(StageContext context, Workers& workers, PhotonKind kind, PhotonTracing& tracing) {
  PhotonCounts count;
  // All wavelengths: the result must not depend on which set of maps is built first.
  context.wavelength_sample = -1.0f;
  std::uint64_t next = kMinProbePhotons;
  while (count.stored < kProbeStoredPhotons && count.emitted < kMaxProbePhotons && context.scene.lights.count > 0 &&
         !tracing.stopped()) {
    const std::uint64_t first = first_photon(kind, kMaxPhotonSets) + count.emitted;
    for (const StoredPhotons& task : trace_tasks(context, workers, kind, first, next, tracing, 0))
      count.stored += task.counted;
    count.emitted += next;
    next = count.emitted;
  }
  return count;
}

/// The photons of each task, and the number of photons emitted for them, at least 1.
struct TracedPhotons {
  std::vector<std::vector<Photon>> tasks;
  std::vector<std::vector<PhotonBeam>> beams;
  std::uint64_t emitted = 0;
};

TracedPhotons trace(const StageContext& context, Workers& workers, const PhotonRequest& request,
                    PhotonTracing& tracing) {
  const std::uint64_t start = timestamp();
  const std::uint64_t emitted = context.scene.lights.count > 0 ? request.emitted : 0;
  TracedPhotons out;
  for (StoredPhotons& task : trace_tasks(context, workers, request.kind, first_photon(request.kind, request.set),
                                         emitted, tracing, request.expected)) {
    tracing.report.stored += task.photons.size() + task.beams.size();
    out.tasks.push_back(std::move(task.photons));
    out.beams.push_back(std::move(task.beams));
  }
  if (emitted == 0) tracing.on_stored(request.expected);
  tracing.report.emitted += emitted;
  tracing.report.trace_seconds += seconds_since(start);
  out.emitted = std::max<std::uint64_t>(emitted, 1);
  return out;
}

}  // namespace

std::uint64_t photons_to_emit(const StageContext& context, Workers& workers, PhotonKind kind, std::uint64_t count,
                              std::uint64_t max_emitted, PhotonTracing& tracing) {
  if (count == 0) return 0;
  const std::uint64_t start = timestamp();
  const PhotonCounts probe = estimate_storing_rate(context, workers, kind, tracing);
  tracing.report.trace_seconds += seconds_since(start);
  const double rate =
      static_cast<double>(probe.stored) / static_cast<double>(std::max<std::uint64_t>(probe.emitted, 1));
  const double needed = rate > 0 ? std::ceil(static_cast<double>(count) / rate) : 0;
  if (rate > 0 && needed <= static_cast<double>(max_emitted)) return static_cast<std::uint64_t>(needed);
  const std::uint64_t emitted = rate > 0 ? max_emitted : count;
  if (!tracing.stopped())
    tracing.warnings.push_back(
        fmt::format("the {} holds about {} of the {} requested photons: too few of the {} emitted photons reach places "
                    "where they are stored",
                    kMapNames[map_of(kind)], std::llround(rate * static_cast<double>(emitted)), count, emitted));
  return emitted;
}

PhotonMap trace_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                        PhotonTracing& tracing) {
  TracedPhotons traced = trace(context, workers, request, tracing);
  const std::uint64_t start = timestamp();
  const PhotonMappingSettings& settings = context.integrator.photons;
  PhotonMap map(traced.tasks, traced.emitted, request.radius, settings.kernel, settings.lookup_size,
                context.scene.color == ColorMode::kSpectral);
  tracing.report.index_seconds += seconds_since(start);
  return map;
}

VolumePhotonMaps trace_volume_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                                      PhotonTracing& tracing) {
  TracedPhotons traced = trace(context, workers, request, tracing);
  const std::uint64_t start = timestamp();
  const PhotonKernel kernel = context.integrator.photons.kernel;
  VolumePhotonMaps map{{traced.tasks, traced.emitted, request.radius, kernel}, {}};
  if (context.integrator.photons.uses_beams())
    map.beams = {traced.beams, traced.emitted, request.beam_radius, kMaxBeamSegment * context.scene.radius, kernel};
  tracing.report.index_seconds += seconds_since(start);
  return map;
}

}  // namespace sheaf

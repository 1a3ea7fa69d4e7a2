// A wave: the paths one worker has in flight, in memory that fits its L2 cache and that no other worker touches.
#pragma once

#include "core/stats.h"
#include "kernels/path_state.h"
#include "scene/film.h"
#include "scene/scene.h"

namespace sheaf {

/// Surface items of one closure kind: sorted[slot_begin .. slot_begin + count) stand in the columns from
/// `column_begin` on, which is a multiple of kWidth.
struct SurfaceRun {
  int slot_begin = 0, count = 0, column_begin = 0;
};

/// Camera samples that one worker renders in one go: all samples [first_sample, first_sample + sample_count) of a
/// rectangle of pixels, pixel by pixel.
struct TileSamples {
  PixelRect pixels;
  std::uint32_t first_sample = 0, sample_count = 0;
  int frame_width = 0;

  int total() const { return pixels.width() * pixels.height() * static_cast<int>(sample_count); }
};

/// Sees every packet just before it is traced; for benchmarks.
class RayRecorder {
 public:
  enum class Query { kNearest, kAny };
  virtual ~RayRecorder() = default;
  virtual void record(const RayPacket& packet, int count, Query query) = 0;
};

/// All of a worker's queues. Constructed by the worker itself, so that its memory is local to it.
struct Wave {
  /// `capacity`: paths in flight; at least 1.
  explicit Wave(int capacity);
  Wave(const Wave&) = delete;
  Wave& operator=(const Wave&) = delete;

  /// Bytes of all queues per path.
  static std::size_t bytes_per_path();
  /// The capacity whose queues fill half of the L2 cache: a multiple of 64 in [256, 4096].
  static int default_capacity();

  /// Begins a task: `samples` receives one value per camera sample, in the order of TileSamples; so does `spectra`,
  /// if not null, for a film with `bins` spectral bins.
  void begin(const TileSamples& task, FilmSample* samples, SpectralSample* spectra = nullptr, int bins = 0);

  int capacity;
  Arena arena;

  // Reached by slot.
  Groups<RayState> rays;
  Groups<HitState> hits;
  Groups<ThroughputState> throughput;
  Groups<RadianceState> radiance;
  /// Spectral mode: what the wavelengths are made of, one word per slot; see kernels/path_wavelengths.h.
  float* heroes = nullptr;
  // Only used where SceneView::has_transparency.
  Groups<ProbabilityState> probabilities;
  float* travelled = nullptr;  ///< distance from where each path was scattered last to its ray's origin

  // Lists of slots. A slot stands in exactly one of free, active, medium, miss, composite, surface and finished between
  // stages, and may stand in emitter besides.
  SlotList free;      ///< no path
  SlotList active;    ///< ray to be traced
  SlotList medium;    ///< ray is in a medium
  SlotList miss;      ///< ray left the scene
  SlotList emitter;   ///< ray hit something that emits
  SlotList composite; ///< ray hit a material that is a choice between others or nothing
  SlotList surface;   ///< ray hit something that will be shaded
  SlotList finished;  ///< path has ended, radiance complete

  // Surface items, sorted; and shadow rays. Consumed in order.
  SlotList sorted;
  std::uint8_t* sort_keys = nullptr;
  SurfaceRun runs[kClosureKinds];
  Soa<SurfaceItem> items;
  Soa<TexturedItem> textured;
  Soa<ClosureItem> closures;
  Soa<LightCandidate> candidates;
  Soa<ReservoirItem> reservoirs;
  int candidate = 0;  ///< the one being worked on, below IntegratorDescription::candidates
  Soa<ShadowItem> shadows;
  Soa<TransmittanceItem> transmittances;
  int shadow_count = 0;

  // The task.
  TileSamples task;
  FilmSample* task_samples = nullptr;
  SpectralSample* task_spectra = nullptr;
  int spectral_bins = 0;
  int next_sample = 0;  ///< of the task, to be started next

  Stats stats;
  /// First sample that was dropped, for the message.
  struct Dropped {
    bool any = false;
    std::uint32_t pixel = 0, sample = 0;
  } first_dropped;
  RayRecorder* recorder = nullptr;
};

}  // namespace sheaf

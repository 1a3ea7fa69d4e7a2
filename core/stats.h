// Statistics of a render: counters per worker, their sum, and the report.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#if defined(__x86_64__) || defined(__i386__)
#include <x86intrin.h>
#endif

namespace sheaf {

/// Index of a stage of a pass, defined by kernels/stages/stage_list.h.
enum class Stage : std::uint32_t;
/// Upper bound on the number of stages.
inline constexpr std::size_t kMaxStages = 32;

/// A fast time stamp in ticks of unspecified length. Monotonic on one thread; costs a few nanoseconds.
inline std::uint64_t timestamp() {
#if defined(__x86_64__) || defined(__i386__)
  return __rdtsc();
#else
  return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

/// The length of one tick of timestamp() in seconds. The first call measures it for 5 ms; thread-safe.
double seconds_per_tick();

/// The peak resident set size of this process in bytes; 0 if unknown.
std::uint64_t peak_rss_bytes();

/// The peak resident set size minus the file pages that are resident now, mostly code of libraries. Heap, stacks, and
/// data that libraries have written to remain. In bytes; 0 if unknown.
std::uint64_t peak_private_bytes();

/// Counters of one stage.
struct StageStats {
  std::uint64_t calls = 0;         ///< times the stage ran on a wave
  std::uint64_t items = 0;         ///< queue entries consumed
  std::uint64_t batches = 0;       ///< SIMD registers processed
  std::uint64_t active_lanes = 0;  ///< lanes of those registers that held an item; at most batches * kWidth
  std::uint64_t ticks = 0;         ///< of timestamp()

  StageStats& operator+=(const StageStats& other);
  double seconds() const { return static_cast<double>(ticks) * seconds_per_tick(); }
  /// Nanoseconds per item; 0 without items.
  double ns_per_item() const;
  /// Share of the SIMD lanes that did useful work, in [0, 1]; 0 without batches.
  double lane_fill() const;
};

/// Adds the time between its construction and its destruction to a sum of ticks.
class ScopedTimer {
 public:
  explicit ScopedTimer(std::uint64_t& sum) : sum_(sum), start_(timestamp()) {}
  ~ScopedTimer() { sum_ += timestamp() - start_; }
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;

 private:
  std::uint64_t& sum_;
  std::uint64_t start_;
};

/// Shadow rays of light sampling to one light, and the radiance that they contributed.
struct LightStats {
  std::uint64_t rays = 0;     ///< shadow rays towards it
  std::uint64_t arrived = 0;  ///< shadow rays that were not occluded
  double radiance = 0;        ///< contributed to the image, sum over samples and components

  LightStats& operator+=(const LightStats& other) {
    rays += other.rays;
    arrived += other.arrived;
    radiance += other.radiance;
    return *this;
  }
};

/// All counters of one worker; the sum over all workers describes a render. Aligned to cache lines, so that the
/// workers' elements of an array share no line.
struct alignas(64) Stats {
  std::array<StageStats, kMaxStages> stages;
  struct Rays {
    std::uint64_t camera = 0;   ///< from the camera
    std::uint64_t light = 0;    ///< photons from the lights
    std::uint64_t scatter = 0;  ///< continued after a surface or a medium
    std::uint64_t shadow = 0;   ///< visibility towards a light
    std::uint64_t total() const { return camera + light + scatter + shadow; }
  } rays;
  /// Collisions while tracking through media.
  struct Collisions {
    std::uint64_t real = 0;       ///< real collisions of paths
    std::uint64_t null = 0;       ///< null collisions of paths, or steps of ray marching
    std::uint64_t shadow = 0;     ///< tentative collisions, or steps, of shadow rays
    std::uint64_t abandoned = 0;  ///< rays that ended after kMaxCollisions of kernels/media/density_tracking.h
    Collisions& operator+=(const Collisions& other) {
      real += other.real;
      null += other.null;
      shadow += other.shadow;
      abandoned += other.abandoned;
      return *this;
    }
  } collisions;
  std::uint64_t trace_ticks = 0;  ///< inside Embree, of timestamp()
  std::uint64_t samples = 0;      ///< camera samples that reached the film
  struct Dropped {
    std::uint64_t rays = 0;     ///< not finite, not traced
    std::uint64_t samples = 0;  ///< NaN, infinite or negative radiance
  } dropped;

  std::vector<LightStats> lights;  ///< by row; lights beyond its end are not counted separately

  StageStats& operator[](Stage stage) { return stages[static_cast<std::size_t>(stage)]; }
  const StageStats& operator[](Stage stage) const { return stages[static_cast<std::size_t>(stage)]; }
  Stats& operator+=(const Stats& other);
};

/// The content of `--stats`: settings, times, and the counters of all workers together.
struct RenderReport {
  std::string scene;          ///< the scene file, as given
  std::string integrator;     ///< "path", "normals" ...
  std::string color = "rgb";  ///< colour mode
  std::string isa;            ///< instruction set of the kernels, e.g. "avx2"
  int width = 0, height = 0;  ///< of the frame, pixels
  std::uint32_t spp = 0;      ///< samples per pixel
  /// Stopped before all samples were taken. `mean_samples` is the mean number of samples per pixel, or for light
  /// tracing the number of photons per pixel of the frame.
  bool interrupted = false;
  double mean_samples = 0;
  std::uint32_t seed = 0;
  int threads = 0;
  int wave_size = 0;          ///< paths per wave
  double load_seconds = 0;    ///< reading files
  double build_seconds = 0;   ///< compiling the scene, with its acceleration structure
  double render_seconds = 0;  ///< wall clock of the render alone
  /// Number of photons in photon maps, and the time to make the maps.
  struct Photons {
    std::uint64_t emitted = 0, stored = 0;
    double trace_seconds = 0;  ///< tracing photons from the lights
    double index_seconds = 0;  ///< building the maps
  } photons;
  /// Training of the guide, and its time. The times of the stages include its passes.
  struct Guiding {
    std::uint64_t passes = 0, samples = 0;  ///< training passes, and their camera samples
    std::uint64_t records = 0, places = 0;  ///< training samples with light, and guide cells that learned from them
    double trace_seconds = 0;               ///< tracing paths
    double fit_seconds = 0;                 ///< fitting the guide to the training samples
  } guiding;
  /// Adaptive sampling: the number of samples.
  struct Adaptive {
    double noise_target = 0;  ///< target noise of each tile; 0: none
    double mean_samples = 0;  ///< per pixel, of the samples that are used
    std::uint32_t least_samples = 0, most_samples = 0;
    std::uint64_t tiles = 0, reached = 0;  ///< tiles of the image, and tiles that reached the target
  };
  std::optional<Adaptive> adaptive;
  std::uint64_t peak_rss_bytes = 0, peak_private_bytes = 0;
  std::vector<std::string_view> stage_names;        ///< of all stages, in the order of Stats::stages
  std::vector<std::string> light_source_locations;  ///< "file:line" of each light in Stats::lights, or empty
  /// Relative standard error of a pixel: root mean square over the image without the worst 0.1 %. Absent if variances
  /// are unknown.
  std::optional<double> noise;
  Stats stats;

  /// Rays of all kinds per second of rendering; 0 if no time passed.
  double rays_per_second() const;
  /// Share of all workers' rendering time spent inside Embree: trace seconds / (render_seconds * threads).
  double trace_share() const;
  /// Factor on the number of samples that reduces the noise to `target`; 0 if the noise is unknown.
  double samples_factor(double target) const;
};

/// Maximum number of lights in a report.
inline constexpr std::size_t kReportedLights = 10;
/// Indices of the lights with the most shadow rays, in descending order. Omits lights without shadow rays.
std::vector<std::size_t> costliest_lights(const Stats& stats, std::size_t most = kReportedLights);

/// The report as JSON text, one object with the keys that the command line's help lists.
std::string to_json(const RenderReport& report);

/// The report as a human-readable table; lines end in '\n'. Omits stages without items.
std::string to_table(const RenderReport& report);

}  // namespace sheaf

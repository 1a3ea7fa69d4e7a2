// The report of a render: settings, times and statistics.
#pragma once

#include "core/io/memory.h"
#include "kernels/film/adaptive_film.h"
#include "kernels/wave/wave_stats.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Settings, times, and the counters of all workers together. tools/report/ formats it.
struct RenderReport {
  std::string scene;          ///< the scene file, as given
  std::string integrator;     ///< its name as given, such as "path_mats"
  std::string color = "rgb";  ///< color mode
  std::string isa;            ///< instruction set of the kernels, e.g. "avx2"
  int width = 0, height = 0;  ///< of the frame, pixels
  std::uint32_t spp = 0;      ///< samples per pixel
  /// Stopped before all samples were taken. `mean_samples` is the mean number of samples per pixel, or for light
  /// tracing the number of photons per pixel of the frame.
  bool interrupted = false;
  double mean_samples = 0;
  std::uint32_t seed = 0;
  int threads = 0;
  int wave_size = 0;         ///< paths per wave
  double load_seconds = 0;   ///< reading files
  double build_seconds = 0;  ///< compiling the scene, with its acceleration structure
  /// The same time by cause: scene file and meshes, images of textures, tables, and the acceleration structure.
  struct Loading {
    double reading_seconds = 0, texture_seconds = 0, compile_seconds = 0, accel_seconds = 0;
  } loading;
  std::vector<MemoryUse> memory;  ///< of the scene, measured, and of the render, estimated before it
  std::uint64_t triangles = 0;    ///< of the scene, without copies by instances
  std::string bvh;                ///< layout of the acceleration structure, "fast" or "compact"
  std::string bvh_build;          ///< how it was built, and why; empty: unknown
  double render_seconds = 0;      ///< wall-clock time of rendering only
  /// Number of photons in photon maps, and the time to make the maps.
  struct Photons {
    std::uint64_t emitted = 0, stored = 0;
    double trace_seconds = 0;  ///< tracing photons from the lights
    double index_seconds = 0;  ///< building the maps
    /// The maps that some samples use: a pass of progressive photon mapping, or a set of wavelengths.
    struct Maps {
      /// Lookup radii, m; 0: no such map.
      float global_radius = 0, caustic_radius = 0, volume_radius = 0, beam_radius = 0;
      std::uint64_t photons = 0, bytes = 0;  ///< stored photons and beams, and memory of the maps
    };
    std::uint64_t passes = 0;  ///< number of these maps
    Maps first, last;
  } photons;
  /// Training of the guide, and its time. The times of the stages include its passes.
  struct Guiding {
    std::uint64_t passes = 0, samples = 0;  ///< training passes, and their camera samples
    std::uint64_t records = 0, cells = 0;   ///< training samples with light, and guide cells that learned from them
    double trace_seconds = 0;               ///< tracing paths
    double fit_seconds = 0;                 ///< fitting the guide to the training samples
    std::optional<double> gain;             ///< GuidingGain::ratio, if training has estimated it
    bool is_used = false;                   ///< the samples of the image are guided
  } guiding;
  /// Light candidates per vertex.
  struct Candidates {
    int count = 1;
    std::vector<double> gains;  ///< CandidateChoice::gains, if a comparison has chosen the number
  } candidates;
  std::optional<AdaptiveSummary> adaptive;  ///< with adaptive sampling
  std::uint64_t peak_rss_bytes = 0, peak_private_bytes = 0;
  std::vector<std::string_view> stage_names;        ///< of all stages, in the order of Stats::stages
  std::vector<std::string> light_source_locations;  ///< "file:line" of each light in Stats::lights, or empty
  /// Relative standard error of a pixel: root mean square over the image without the worst 0.1 %. Absent if variances
  /// are unknown.
  std::optional<double> noise;
  Stats stats;

  /// Rays of all kinds per second of rendering; 0 if no time passed.
  double rays_per_second() const;
  /// Fraction of all workers' rendering time spent inside Embree: trace seconds / (render_seconds * threads).
  double trace_fraction() const;
  /// Factor on the number of samples that reduces the noise to `target`; 0 if the noise is unknown.
  double samples_factor(double target) const;
};

}  // namespace sheaf

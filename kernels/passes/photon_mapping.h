// The photon maps of a render: the number of sets of maps, when they are built, and which samples use them.
//
// Usually one set serves all samples. If there are more, adjacent samples use different sets. Progressive photon
// mapping has one set per sample per pixel, with shrinking radii, and keeps only one at a time (Knaus and Zwicker,
// "Progressive Photon Mapping: A Probabilistic Approach", 2011; Jarosz et al., "Progressive Photon Beams", 2011). In
// spectral mode photons and paths must agree on their wavelengths. So each set of maps and the samples that use it
// share the same four wavelengths, and the requested photons are divided among the sets.
#pragma once

#include "kernels/passes/trace_photons.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// Whether any medium scatters, so that media can store photons.
bool has_phase_functions(const SceneView& scene);

/// Number of sets of maps for `samples` samples per pixel.
std::uint32_t photon_map_sets(const PhotonMappingSettings& settings, ColorMode color, std::uint32_t samples);

class PhotonMapping {
 public:
  /// For a render of `samples` samples per pixel (camera samples times gather rays), at most kMaxPhotonSets with
  /// progressive maps. `context`: of the camera pass. `film_side`: longer side of the frame, pixels.
  PhotonMapping(const StageContext& context, std::uint32_t samples, int film_side);

  /// Builds the maps of sample `sample` if they do not exist yet, and makes `context` gather from them. The maps remain
  /// valid until they are built for another sample, at most as long as this object. The first sample may be any; the
  /// others follow in order.
  void prepare(std::uint32_t sample, Workers& workers, PhotonTracing& tracing, StageContext& context);

  /// Total number of photons to be stored, for progress.
  std::uint64_t photon_total() const {
    return sets_ * (count_of(settings_.global) + count_of(settings_.caustic) + count_of(settings_.volume));
  }

 private:
  struct Set {
    PhotonMap global, caustic;
    VolumePhotonMaps volume;
    PhotonMaps maps;
    bool is_made = false;
  };

  /// Photons to store per set.
  std::uint64_t count_of(const PhotonMapSettings& map) const;
  /// Photons to emit per set, the same for all sets.
  std::uint64_t emitted_for(const PhotonMapSettings& map, PhotonKind kind, Workers& workers, PhotonTracing& tracing,
                            const StageContext& context) const;
  float first_radius_of(const PhotonMapSettings& map) const;
  float radius_of(const PhotonMapSettings& map) const;
  float beam_radius() const;
  /// The photons that the global map holds.
  PhotonKind global_kind() const;
  /// Determines how many photons each map emits.
  void plan(Workers& workers, PhotonTracing& tracing, const StageContext& context);
  void make(std::uint32_t index, Set& set, Workers& workers, PhotonTracing& tracing, const StageContext& context);
  /// Adds the radii and the memory of a set to the report.
  static void report(const Set& set, RenderReport::Photons& report);

  PhotonMappingSettings settings_;
  /// Radius of the scene's bounding sphere, m, and this radius over the number of pixels of the frame's longer side.
  float scene_radius_, pixel_;
  std::uint64_t sets_;
  float offset_ = -1;       ///< shift in [0, 1) of the numbers that give wavelengths; -1: RGB mode
  std::uint32_t pass_ = 0;  ///< pass to which `shrunk_` belongs
  /// Squared radius over that of the first pass; for beams, the radius over that of the first pass.
  double shrunk_ = 1;
  bool is_planned_ = false;
  std::uint64_t global_emitted_ = 0, caustic_emitted_ = 0, volume_emitted_ = 0;  ///< photons per set
  std::vector<Set> made_;
};

}  // namespace sheaf

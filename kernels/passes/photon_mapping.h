// The photon maps of a render: how many sets of them there are, when they are made, and which samples ask which.
//
// One set serves all samples, but for two cases. Progressive photon mapping has a set for each sample per pixel, with
// smaller and smaller radii, of which only one is kept at a time (Knaus and Zwicker, "Progressive Photon Mapping: A
// Probabilistic Approach", 2011; Jarosz et al., "Progressive Photon Beams", 2011). And in spectral mode photons and
// paths must agree on their wavelengths: all of a set and all of the samples that ask it have the same four, and sets
// share the photons that were asked for.
#pragma once

#include "kernels/passes/trace_photons.h"
#include "kernels/photons/photon_maps.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// Whether any medium scatters, so that there may be photons in it.
bool has_phase_functions(const SceneView& scene);

class PhotonMapping {
 public:
  /// For a render of `samples` samples per pixel (camera samples times gather rays). `context`: of the camera pass;
  /// `film_side`: pixels, the longer side of the frame. Throws Error (usage) where there are too many passes.
  PhotonMapping(const StageContext& context, std::uint32_t samples, int film_side);

  /// How many of the next `most` samples ask the same set.
  std::uint32_t samples_alike(std::uint32_t most) const { return sets_ == 1 ? most : 1u; }
  /// Makes the maps that sample `sample` asks where they are not there yet, and tells `context` of them. They live as
  /// long as this, or until they are made for another sample. Samples come in order, the first being any.
  void prepare(std::uint32_t sample, Workers& workers, PhotonTracing& tracing, StageContext& context);
  /// Photons that are to be stored in all, for progress.
  std::uint64_t wanted() const {
    return sets_ * (count_of(settings_.global) + count_of(settings_.caustic) + count_of(settings_.volume));
  }

 private:
  struct Set {
    PhotonMap global, caustic;
    VolumePhotonMaps volume;
    PhotonMaps maps;
    bool is_made = false;
  };

  /// Photons to be stored for one set.
  std::uint64_t count_of(const PhotonMapDescription& map) const;
  /// Photons to be emitted for one set, the same for all sets.
  std::uint64_t emitted_for(const PhotonMapDescription& map, PhotonKind kind, Workers& workers, PhotonTracing& tracing,
                            const StageContext& context) const;
  float first_radius_of(const PhotonMapDescription& map) const;
  float radius_of(const PhotonMapDescription& map) const;
  float beam_radius() const;
  /// Which photons the global map holds.
  PhotonKind global_kind() const;
  /// Fixes how many photons each map emits.
  void plan(Workers& workers, PhotonTracing& tracing, const StageContext& context);
  void make(std::uint32_t index, Set& set, Workers& workers, PhotonTracing& tracing, const StageContext& context);

  PhotonMappingDescription settings_;
  std::uint64_t sets_ = 1;
  float scene_radius_, pixel_;  ///< of the scene's bounding sphere; a pixel's share of it
  float offset_ = -1;           ///< in [0, 1), of the numbers that wavelengths are made of; -1: RGB mode
  std::uint32_t pass_ = 0;      ///< that radii are shrunk for
  double shrunk_ = 1;           ///< square of the radius over what it was in the first pass; the radius of beams itself
  bool is_planned_ = false;
  std::uint64_t global_emitted_ = 0, caustic_emitted_ = 0, volume_emitted_ = 0;  ///< photons, for each set
  std::vector<Set> made_;
};

}  // namespace sheaf

// Photon maps from a scene: photons are emitted until as many as asked for are stored.
#pragma once

#include "kernels/passes/worker.h"
#include "kernels/photons/photon_beam_map.h"
#include "kernels/photons/photon_map.h"
#include "kernels/photons/volume_photon_map.h"

#include <functional>
#include <string>

namespace sheaf {

/// How tracing goes on and ends.
struct PhotonTracing {
  std::function<bool()> stopped;                 ///< true ends it
  std::function<void(std::uint64_t)> on_stored;  ///< so many more of the photons that were asked for
  std::vector<std::string> warnings = {};        ///< out: what went wrong, for the user
  RenderReport::Photons report = {};             ///< out, sums over all maps
  bool scarce[3] = {};  ///< out: hardly any photons arrive for the global, the caustics, the volume map
};

/// A photon map to be made.
struct PhotonRequest {
  std::uint64_t count = 0;  ///< photons to be stored
  float radius = 0;         ///< metres, within which they are to be found
  PhotonKind kind = PhotonKind::kAll;
  std::uint32_t set = 0;  ///< maps of different sets share no random numbers
  float beam_radius = 0;  ///< metres, of beams
};

/// Photons in media, in one way and the other; of each medium in one of them. See keeps_beams().
struct VolumePhotonMaps {
  VolumePhotonMap points;
  PhotonBeamMap beams;
};

/// Photons until as many are stored as requested; fewer, and a warning, where light hardly arrives on what stores them,
/// or `stopped`. Where only some kind is kept, others count towards the number all the same, but for caustics. The map
/// depends on the scene, the seed and the request alone. `context`: of a camera pass, with settings of photon mapping
/// and of wavelengths.
PhotonMap trace_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                        PhotonTracing& tracing);

/// The same for PhotonKind::kVolume; beams count as points do.
VolumePhotonMaps trace_volume_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                                      PhotonTracing& tracing);

}  // namespace sheaf

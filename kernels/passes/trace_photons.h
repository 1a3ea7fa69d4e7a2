// Photon maps from a scene. How many photons a map takes is fixed before it is made, by a pilot that has random numbers
// of its own: emitting until enough are stored, and dividing by the number that were emitted, is biased by about 1 / n.
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
};

/// A photon map to be made.
struct PhotonRequest {
  std::uint64_t emitted = 0;  ///< photons to be emitted; see photons_to_emit()
  float radius = 0;           ///< metres, within which they are to be found
  PhotonKind kind = PhotonKind::kAll;
  std::uint32_t set = 0;       ///< maps of different sets share no random numbers; below kMaxPhotonSets
  float beam_radius = 0;       ///< metres, of beams
  std::uint64_t expected = 0;  ///< photons that are expected to be stored, for progress alone
};

/// Most sets of maps.
inline constexpr std::uint32_t kMaxPhotonSets = 1 << 22;

/// Photons in media, in one way and the other; of each medium in one of them. See keeps_beams().
struct VolumePhotonMaps {
  VolumePhotonMap points;
  PhotonBeamMap beams;
};

/// The number of photons to emit so that about `count` of a kind are stored, but at most `max_emitted`, with a warning;
/// `count` where the pilot stores none. For the global map, photons of other kinds count too. Depends on the scene, the
/// seed and the arguments alone, so that all sets of maps emit as many.
std::uint64_t photons_to_emit(const StageContext& context, Workers& workers, PhotonKind kind, std::uint64_t count,
                              std::uint64_t max_emitted, PhotonTracing& tracing);

/// Emits photons and sorts what they store into a map, which depends on the scene, the seed and the request alone; it
/// is incomplete where `stopped`. `context`: of a camera pass, with settings of photon mapping and of wavelengths.
PhotonMap trace_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                        PhotonTracing& tracing);

/// The same for PhotonKind::kVolume; beams count as points do.
VolumePhotonMaps trace_volume_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                                      PhotonTracing& tracing);

}  // namespace sheaf

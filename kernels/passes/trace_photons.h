// Traces photons and builds photon maps. The number of photons that a map emits is fixed in advance by a probe with
// random numbers of its own. Emitting until enough photons are stored, and dividing by the number emitted, would be
// biased by about 1 / n.
#pragma once

#include "kernels/passes/render_report.h"
#include "kernels/passes/worker.h"
#include "kernels/photons/photon_maps.h"

#include <functional>
#include <string>

namespace sheaf {

/// Callbacks and results of photon tracing.
struct PhotonTracing {
  std::function<bool()> stopped;                 ///< true ends tracing
  std::function<void(std::uint64_t)> on_stored;  ///< progress: more of the requested photons were stored
  std::vector<std::string> warnings = {};        ///< out: for the user
  RenderReport::Photons report = {};             ///< out: sums over all maps
};

/// A photon map to be built.
struct PhotonRequest {
  std::uint64_t emitted = 0;  ///< number of photons to emit; see photons_to_emit()
  float radius = 0;           ///< lookup radius, m
  PhotonKind kind = PhotonKind::kAll;
  std::uint32_t set = 0;       ///< index below kMaxPhotonSets; sets share no random numbers
  float beam_radius = 0;       ///< radius of beams, m
  std::uint64_t expected = 0;  ///< expected number of stored photons, for progress only
};

/// Maximum number of sets of maps.
inline constexpr std::uint32_t kMaxPhotonSets = 1 << 22;

/// Number of photons to emit so that about `count` photons of a kind are stored: at most `max_emitted`, or `count` if
/// the probe stores none, both with a warning. For the global map, photons of other kinds count too. Depends only on
/// scene, seed and arguments, so that all sets of maps emit the same number.
std::uint64_t photons_to_emit(const StageContext& context, Workers& workers, PhotonKind kind, std::uint64_t count,
                              std::uint64_t max_emitted, PhotonTracing& tracing);

/// Emits photons and builds a map of those that are stored. The map depends only on scene, seed and request; it is
/// incomplete if tracing was `stopped`. `context`: of a camera pass, with the settings of photon mapping and the
/// wavelengths.
PhotonMap trace_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                        PhotonTracing& tracing);

/// The same for PhotonKind::kVolume; beams count like points.
VolumePhotonMaps trace_volume_photons(const StageContext& context, Workers& workers, const PhotonRequest& request,
                                      PhotonTracing& tracing);

}  // namespace sheaf

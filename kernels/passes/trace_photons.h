// Photon maps from a scene: photons are emitted until as many as asked for are stored.
#pragma once

#include "kernels/passes/worker.h"
#include "kernels/photons/photon_map.h"

#include <functional>
#include <string>

namespace sheaf {

/// How tracing goes on and ends.
struct PhotonTracing {
  std::function<bool()> stopped;                 ///< true ends it
  std::function<void(std::uint64_t)> on_stored;  ///< so many more of the photons that were asked for
  std::vector<std::string> warnings = {};        ///< out: what went wrong, for the user
  std::uint64_t emitted = 0;                     ///< out
};

/// Photons until `description.count` of them are stored; fewer, and a warning, where light hardly arrives on what
/// stores them, or `stopped`. The map depends on the scene, the seed and the description alone. `context`: of a camera
/// pass.
PhotonMap trace_photons(const StageContext& context, Workers& workers, const PhotonMapDescription& description,
                        PhotonKind kind, PhotonKernel kernel, PhotonTracing& tracing);

}  // namespace sheaf

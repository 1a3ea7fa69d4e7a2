// What scene files say of photon maps.
#pragma once

#include <cstdint>

namespace sheaf {

/// How photons count by their distance d from the point at which they are gathered, within the radius r.
enum class PhotonKernel {
  kDisc,          ///< all alike
  kCone,          ///< 1 - d / r
  kEpanechnikov,  ///< 1 - d^2 / r^2
};

/// One photon map.
struct PhotonMapDescription {
  std::uint64_t count = 0;    ///< photons to be stored; 0: there is no such map
  float radius = 0;           ///< metres; 0: by `relative_radius`
  float relative_radius = 0;  ///< over the radius of the scene's bounding sphere
};

/// Settings of the integrator `photonmapper`.
struct PhotonMappingDescription {
  PhotonMapDescription global{1'000'000, 0, 0.004f};
  PhotonMapDescription caustic{0, 0, 0.0125f};
  bool final_gather = false;  ///< the map is looked up where rays from the first diffuse surface end, not there
  int gather_rays = 1;        ///< of final gathering per camera sample: each is a sample of its own
  PhotonKernel kernel = PhotonKernel::kDisc;
};

/// Most photons of a map: places in it are counted in 32 bits.
inline constexpr std::uint64_t kMaxPhotons = 1'000'000'000;

}  // namespace sheaf

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

/// Which light photons bring to the first surface x, seen from the camera, that is not specular.
enum class PhotonGathering {
  kAll,       ///< all
  kIndirect,  ///< all but what comes from lights directly: that is sampled
  kFinal,     ///< final gathering: none but caustics; rays go on from x, and photons are looked up where those end
};

/// What is kept of photons in media.
enum class MediumPhotons {
  kAuto,    ///< kBeams in progressive maps, else kPoints
  kPoints,  ///< where they are scattered
  kBeams,   ///< in homogeneous media the lines that they fly along; else as kPoints
};

/// One photon map.
struct PhotonMapDescription {
  std::uint64_t count = 0;    ///< photons to be stored, about; 0: there is no such map
  float radius = 0;           ///< metres; 0: by `relative_radius`
  float relative_radius = 0;  ///< over the radius of the scene's bounding sphere; 0: five pixels' worth of it
};

/// Settings of the integrators `photonmapper`, `ppm` and `sppm`.
struct PhotonMappingDescription {
  PhotonMapDescription global{1'000'000, 0, 0.004f};
  PhotonMapDescription caustic{0, 0, 0.0125f};
  PhotonMapDescription volume{0, 0, 0.01f};  ///< in media; 0 photons: paths are scattered there
  MediumPhotons medium_photons = MediumPhotons::kAuto;
  PhotonGathering gathering = PhotonGathering::kAll;
  int gather_rays = 1;  ///< of kFinal, per camera sample: each is a sample of its own
  PhotonKernel kernel = PhotonKernel::kDisc;
  int lookup_size = 0;       ///< so many photons nearest to the point count, all within the radius if 0
  bool progressive = false;  ///< each sample per pixel has maps of its own, with smaller and smaller radii
  float alpha = 0.7f;  ///< of progressive maps: share of a pass' photons by which the number in reach grows, (0, 1)
  int max_passes = 0;  ///< of progressive maps: samples per pixel; 0: as the sampler says

  bool uses_beams() const {
    return medium_photons == MediumPhotons::kBeams || (medium_photons == MediumPhotons::kAuto && progressive);
  }
};

/// Most photons of a map: places in it are counted in 32 bits.
inline constexpr std::uint64_t kMaxPhotons = 1'000'000'000;
/// Most of PhotonMappingDescription::lookup_size.
inline constexpr int kMaxLookupSize = 4096;

}  // namespace sheaf

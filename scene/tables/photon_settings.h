// Settings of the photon mapping integrators, as read from scene files.
#pragma once

#include <cstdint>

namespace sheaf {

/// Density estimation kernel: weight of a photon at distance d from the query point, within the radius r.
enum class PhotonKernel {
  kDisc,          ///< constant
  kCone,          ///< 1 - d / r
  kEpanechnikov,  ///< 1 - d^2 / r^2
};

/// Light that photons contribute at the first non-specular surface point x seen from the camera.
enum class PhotonGathering {
  kAll,       ///< all light
  kIndirect,  ///< indirect light; direct light is sampled by next-event estimation
  kFinal,  ///< final gathering: caustics only; gather rays continue from x, and the map is queried at their end points
};

/// Representation of photons in media.
enum class MediumPhotons {
  kAuto,    ///< kBeams for progressive maps, otherwise kPoints
  kPoints,  ///< positions of scattering events
  kBeams,   ///< photon beams in homogeneous media; otherwise as kPoints
};

/// Settings of one photon map.
struct PhotonMapSettings {
  std::uint64_t count = 0;    ///< approximate number of stored photons; 0: no such map
  float radius = 0;           ///< meters; 0: use `relative_radius`
  float relative_radius = 0;  ///< relative to the radius of the scene's bounding sphere; 0: the size of five pixels
};

/// Settings of the integrators `photonmapper`, `ppm` and `sppm`.
struct PhotonMappingSettings {
  PhotonMapSettings global{1'000'000, 0, 0.004f};
  PhotonMapSettings caustic{0, 0, 0.0125f};
  PhotonMapSettings volume{0, 0, 0.01f};  ///< in media; 0 photons: paths scatter in media instead
  MediumPhotons medium_photons = MediumPhotons::kAuto;
  PhotonGathering gathering = PhotonGathering::kAll;
  int gather_rays = 1;  ///< kFinal: gather rays per camera sample; each counts as a sample
  PhotonKernel kernel = PhotonKernel::kDisc;
  int lookup_size = 0;       ///< number of nearest photons used per query; 0: all within the radius
  bool progressive = false;  ///< one set of maps per sample per pixel, with shrinking radii
  /// Progressive maps: fraction of a pass's photons by which the number within the radius grows, in (0, 1).
  float alpha = 0.7f;
  int max_passes = 0;  ///< progressive maps: samples per pixel; 0: as set by the sampler

  bool uses_beams() const {
    return medium_photons == MediumPhotons::kBeams || (medium_photons == MediumPhotons::kAuto && progressive);
  }
};

/// Maximum number of photons of a map: indices are 32 bits wide.
inline constexpr std::uint64_t kMaxPhotons = 1'000'000'000;
/// Maximum of PhotonMappingSettings::lookup_size.
inline constexpr int kMaxLookupSize = 4096;

}  // namespace sheaf

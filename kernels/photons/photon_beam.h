// What a photon leaves on its way through a medium: the line that it flies along, until it is scattered or the medium
// ends (Jarosz, Nowrouzezahrai, Sadeghi and Jensen, "A Comprehensive Theory of Volumetric Radiance Estimation Using
// Photon Points and Beams", 2011).
#pragma once

#include "core/spectrum.h"
#include "core/vec.h"
#include "scene/tables/scene.h"

#include <cstdint>

namespace sheaf {

/// One flight of a photon.
struct PhotonBeam {
  Vec3f start, direction;   ///< world space; unit length
  float length = 0;         ///< metres
  Spectrum4 power;          ///< at the start; W, times the number of photons that were emitted
  Spectrum4 odds;           ///< RescaledPdfs::r_u at the start, over the mean of its lanes
  std::uint32_t place = 0;  ///< see photon_place()
  std::uint32_t order = 0;  ///< see Photon::order
};

/// Longer ones end there; and none begins as far from the origin: products of such lengths stay finite. Metres.
inline constexpr float kLongestBeam = 1e12f;

/// Whether photons are kept as beams in a medium, and not as points.
inline bool keeps_beams(const PhotonMappingDescription& settings, const MediumRow& medium) {
  return settings.uses_beams() && (medium.flags & kMediumHomogeneous) != 0;
}

}  // namespace sheaf

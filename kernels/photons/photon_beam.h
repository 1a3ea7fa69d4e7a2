// A photon beam: the flight of a photon through a medium, as a line that ends where the photon scatters or the medium
// ends (Jarosz, Nowrouzezahrai, Sadeghi and Jensen, "A Comprehensive Theory of Volumetric Radiance Estimation Using
// Photon Points and Beams", 2011).
#pragma once

#include "core/color/spectrum.h"
#include "core/math/vec.h"
#include "scene/tables/scene_view.h"

#include <cstdint>

namespace sheaf {

/// A photon beam.
struct PhotonBeam {
  Vec3f start, direction;        ///< world space; unit length
  float length = 0;              ///< meters
  Spectrum4 power;               ///< at the start; W, times the number of emitted photons
  Spectrum4 pdf_ratio;           ///< RescaledPdfs::r_u at the start, over its mean
  std::uint32_t medium_key = 0;  ///< see photon_medium_key()
  std::uint32_t order = 0;       ///< see Photon::order
};

/// Maximum length of a beam, and maximum distance of its start from the origin, in meters. Products of such lengths
/// stay finite.
inline constexpr float kLongestBeam = 1e12f;

/// Whether photons in a medium are stored as beams instead of points.
inline bool keeps_beams(const PhotonMappingSettings& settings, const MediumRow& medium) {
  return settings.uses_beams() && (medium.flags & kMediumHomogeneous) != 0;
}

}  // namespace sheaf

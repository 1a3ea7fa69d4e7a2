// What a photon leaves where it meets a surface that is not specular.
#pragma once

#include "core/spectrum.h"
#include "core/vec.h"

#include <cstdint>

namespace sheaf {

/// Bits of Photon::order for vertices.
inline constexpr int kVertexBits = 16;

/// One photon at one of its vertices.
struct Photon {
  Vec3f p;                      ///< world space
  Spectrum4 power;              ///< W, times the number of photons that were emitted
  std::uint32_t direction = 0;  ///< octahedral; towards where it came from
  std::uint32_t surface = 0;    ///< see photon_surface(), photon_place()
  std::uint32_t order = 0;      ///< photon of the task above, vertex of the photon in the lower kVertexBits
};

/// Most segments of a path that photons count.
inline constexpr std::uint32_t kMaxPhotonEdges = 127;
/// Bit of photon_surface(): one wavelength is left, see kernels/wave/path_wavelengths.h.
inline constexpr std::uint32_t kPhotonSingleWavelength = 128;
/// The octahedral normal of a photon's surface, its last eight bits taken by kPhotonSingleWavelength and the number of
/// segments that its path, from the light, has had so far; only those that cost depth, and at most kMaxPhotonEdges.
inline std::uint32_t photon_surface(std::uint32_t normal, std::uint32_t edges, bool single_wavelength = false) {
  return (normal & ~(kMaxPhotonEdges | kPhotonSingleWavelength)) | (single_wavelength ? kPhotonSingleWavelength : 0u) |
         (edges < kMaxPhotonEdges ? edges : kMaxPhotonEdges);
}

/// Which photons are kept, by the vertices between the light and the surface; those in media count as D.
enum class PhotonKind {
  kAll,            ///< L (S|D)* D
  kAllButCaustic,  ///< L D, and kDiffuse
  kIndirect,       ///< L (S|D)+ D
  kDiffuse,        ///< L S* D (S|D)* D
  kCaustic,        ///< L S+ D
  kVolume,         ///< all, but where they are scattered in media
};

/// Photon::surface of photons in media: the medium, 1 + its row, in place of a normal.
inline constexpr int kPhotonMediumShift = 8;
inline std::uint32_t photon_place(std::uint32_t medium, std::uint32_t edges, bool single_wavelength) {
  return photon_surface(medium << kPhotonMediumShift, edges, single_wavelength);
}

}  // namespace sheaf

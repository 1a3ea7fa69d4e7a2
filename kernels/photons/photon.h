// A photon as stored at the non-specular vertices of its path.
#pragma once

#include "core/color/spectrum.h"
#include "core/math/vec.h"

#include <cstdint>

namespace sheaf {

/// Number of low bits of Photon::order that hold the vertex.
inline constexpr int kVertexBits = 16;

/// A photon at one vertex of its path.
struct Photon {
  Vec3f p;                      ///< world space; in media whose grids move, relative to the grids
  Spectrum4 power;              ///< W, times the number of emitted photons
  std::uint32_t direction = 0;  ///< octahedral; towards the previous vertex
  std::uint32_t surface = 0;    ///< see photon_surface(), photon_medium_key()
  std::uint32_t order = 0;      ///< photon index in the task, above kVertexBits bits for its vertex
};

/// Maximum number of path segments that photons count.
inline constexpr std::uint32_t kMaxPhotonEdges = 127;
/// Bit of photon_surface(): the photon has one wavelength left, see kernels/wave/path_wavelengths.h.
inline constexpr std::uint32_t kPhotonSingleWavelength = 128;
/// The octahedral normal of the photon's surface. Its low eight bits are replaced by kPhotonSingleWavelength and the
/// number of segments from the light. Only segments that cost depth count, up to kMaxPhotonEdges.
inline std::uint32_t photon_surface(std::uint32_t normal, std::uint32_t edges, bool single_wavelength = false) {
  return (normal & ~(kMaxPhotonEdges | kPhotonSingleWavelength)) | (single_wavelength ? kPhotonSingleWavelength : 0u) |
         (edges < kMaxPhotonEdges ? edges : kMaxPhotonEdges);
}

/// The bits of photon_surface() that hold the normal.
inline std::uint32_t photon_normal(std::uint32_t surface) {
  return surface & ~(kMaxPhotonEdges | kPhotonSingleWavelength);
}

/// The photons that are stored, by the vertices between the light and the surface (S specular, D diffuse). Vertices in
/// media count as D.
enum class PhotonKind {
  kAll,            ///< L (S|D)* D
  kAllButCaustic,  ///< L D and kDiffuse
  kIndirect,       ///< L (S|D)+ D
  kDiffuse,        ///< L S* D (S|D)* D
  kCaustic,        ///< L S+ D
  kVolume,         ///< like kAll, but only where photons scatter in media
};

/// Photon::surface of photons in media: 1 + the row of the medium instead of a normal.
inline constexpr int kPhotonMediumShift = 8;
inline std::uint32_t photon_medium_key(std::uint32_t medium, std::uint32_t edges, bool single_wavelength) {
  return photon_surface(medium << kPhotonMediumShift, edges, single_wavelength);
}

}  // namespace sheaf

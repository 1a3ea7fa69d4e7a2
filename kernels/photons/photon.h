// What a photon leaves where it meets a surface that is not specular.
#pragma once

#include "core/spectrum.h"
#include "core/vec.h"

#include <cstdint>

namespace sheaf {

/// One photon at one of its vertices.
struct Photon {
  Vec3f p;                      ///< world space
  Spectrum4 power;              ///< W, times the number of photons that were emitted
  std::uint32_t direction = 0;  ///< octahedral; towards where it came from
  std::uint32_t surface = 0;    ///< see photon_surface()
  std::uint32_t order = 0;      ///< photon of the task, and vertex of the photon
};

/// Most segments of a path that photons count.
inline constexpr std::uint32_t kMostPhotonEdges = 255;
/// The octahedral normal of a photon's surface, its last eight bits taken by the number of segments that its path, from
/// the light, has had so far; only those that cost depth, and at most kMostPhotonEdges.
inline std::uint32_t photon_surface(std::uint32_t normal, std::uint32_t edges) {
  return (normal & ~kMostPhotonEdges) | (edges < kMostPhotonEdges ? edges : kMostPhotonEdges);
}

/// Which photons are kept.
enum class PhotonKind {
  kGlobal,   ///< all: L (S|D)* D
  kCaustic,  ///< those that specular surfaces alone have sent there: L S+ D
};

}  // namespace sheaf

// Which photon map is asked where; what belongs to maps, and what to the path itself.
//
// A path from the camera that meets its first vertex x on a surface that is not specular, all by E S* x:
//     PhotonGathering::kAll       the global map at x holds all that x sends on, but for caustics where there is a
//                                 caustic map; the path ends there
//     PhotonGathering::kIndirect  light is sampled at x, and one ray goes on from it to find lights by the other
//                                 strategy; all else is the maps' at x: caustics the caustic map's, where there is one
//     PhotonGathering::kFinal     light is sampled at x, and one ray goes on from it, that meets surfaces by S* y: the
//                                 global map at y holds all that y sends on, and the path ends there. Light that such a
//                                 ray meets by S+ is the caustic map's at x, where there is one
// With a volume map, paths are not scattered in media: what media send along E S* x is that map's, and along the rays
// of final gathering. Without it, vertices in media belong to no map: light is sampled there and the path goes on. For
// kIndirect, the maps at x have all that the ray from there might meet but lights.
#pragma once

#include "kernels/photons/photon_beam_map.h"
#include "kernels/photons/photon_map.h"
#include "kernels/photons/volume_photon_map.h"
#include "kernels/wave/context.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// The maps of a pass.
struct PhotonMaps {
  PhotonMapView global, caustic;
  PhotonGathering gathering = PhotonGathering::kAll;
  const VolumePhotonMap* volume = nullptr;  ///< null: media scatter paths
  const PhotonBeamMap* beams = nullptr;     ///< with `volume`: of the media of which keeps_beams() is true

  /// Whether a path ends at a vertex that is not specular, but for what is specular of it. `flags`: of the ray that met
  /// it.
  template <class L> SHEAF_INLINE Mask<L> ends_at(Uint<L> flags, bool in_medium) const {
    if (in_medium && gathering != PhotonGathering::kIndirect) return Mask<L>(false);
    const Uint<L> needed(gathering == PhotonGathering::kAll ? 0u : std::uint32_t{kRayDiffuse});
    return (flags & needed) == needed;
  }
  /// The maps to be asked at a surface that is not specular; null or empty: none.
  struct Asked {
    const PhotonMapView *first, *second;
  };
  Asked maps_at(std::uint32_t flags) const {
    const bool behind = (flags & kRayDiffuse) != 0;
    switch (gathering) {
      case PhotonGathering::kAll:
        return {&global, &caustic};
      case PhotonGathering::kIndirect:
        if (behind) return {nullptr, nullptr};
        return {&global, &caustic};
      case PhotonGathering::kFinal:
        return {behind ? &global : &caustic, nullptr};
    }
    return {nullptr, nullptr};
  }
  /// Whether what media scatter towards a ray is the volume map's, and not that of another map where the ray began.
  bool gathers_volume(std::uint32_t flags) const {
    return gathering != PhotonGathering::kIndirect || (flags & kRayDiffuse) == 0;
  }
  /// Whether a map holds the light that reaches x by specular surfaces alone.
  bool hold_caustics() const {
    return gathering == PhotonGathering::kIndirect || (gathering == PhotonGathering::kFinal && !caustic.empty());
  }
};

/// Whether the light that a ray has met is a map's as a caustic: since a surface that is not specular it was scattered
/// as by mirrors alone. `scatter_pdf`: see RadianceState.
template <class L> SHEAF_INLINE Mask<L> is_caustic(const StageContext& context, Uint<L> flags, Float<L> scatter_pdf) {
  using U = Uint<L>;
  if (context.maps == nullptr || !context.maps->hold_caustics()) return Mask<L>(false);
  return ((flags & U(kRayDiffuse | kRayScatteredInMedium)) == U(kRayDiffuse)) & (scatter_pdf == Float<L>(0.0f));
}

/// RayFlags that tell a path's history, behind a vertex that was met with `before`. `specular`: it was scattered as by
/// a mirror.
template <class L, bool InMedium>
SHEAF_INLINE Uint<L> history_behind(const StageContext& context, Uint<L> before, Mask<L> specular) {
  using U = Uint<L>;
  const U kept = before & U(kRayHistory);
  if (context.photons != nullptr)
    return kept | (InMedium ? U(kRayDiffuse) : select(specular, U(kRaySpecular), U(kRayDiffuse)));
  if (InMedium) return kept | U(kRayScatteredInMedium);
  return select(specular, kept, U(kRayDiffuse));
}

}  // namespace sheaf

// Which photon map is asked where; what belongs to maps, and what to the path itself.
//
// A path from the camera that meets its first vertex x on a surface that is not specular, all by E S* x:
//     without final gathering  the global map at x holds all that x sends on, and the path ends there
//     with it                  light is sampled at x, and one ray goes on from it, that meets surfaces by S* y: the
//                              global map at y holds all that y sends on, and the path ends there.
//                              Light that such a ray meets by S+ is the caustic map's, where there is one: it is asked
//                              at x, and what the ray found is not counted.
// Vertices in media belong to no map: light is sampled there and the path goes on.
#pragma once

#include "kernels/photons/photon_map.h"
#include "kernels/wave/context.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// The maps of a pass.
struct PhotonMaps {
  PhotonMapView global, caustic;
  bool final_gather = false;

  /// Whether a path ends at a surface that is not specular, but for what is specular of it. `flags`: of the ray that
  /// met it.
  template <class U> SHEAF_INLINE auto ends_at(U flags) const {
    const U needed(final_gather ? std::uint32_t{kRayDiffuse} : 0u);
    return (flags & needed) == needed;
  }
  /// The map to be asked there.
  const PhotonMapView& map_of(std::uint32_t flags) const { return ends_at(flags) ? global : caustic; }
};

/// Whether the light that a ray has met is the caustic map's: since a surface that is not specular it was scattered as
/// by mirrors alone. `scatter_pdf`: see RadianceState.
template <class L> SHEAF_INLINE Mask<L> is_caustic(const StageContext& context, Uint<L> flags, Float<L> scatter_pdf) {
  using U = Uint<L>;
  if (context.maps == nullptr || !context.maps->final_gather || context.maps->caustic.empty()) return Mask<L>(false);
  return ((flags & U(kRayDiffuse | kRayStrayed)) == U(kRayDiffuse)) & (scatter_pdf == Float<L>(0.0f));
}

/// RayFlags that tell a path's history, behind a vertex that was met with `before`. `specular`: it was scattered as by
/// a mirror.
template <class L, bool InMedium>
SHEAF_INLINE Uint<L> history_behind(const StageContext& context, Uint<L> before, Mask<L> specular) {
  using U = Uint<L>;
  const U kept = before & U(kRayHistory);
  if (context.photons != nullptr)
    return kept | (InMedium ? U(kRayDiffuse) : select(specular, U(kRaySpecular), U(kRayDiffuse)));
  if (InMedium) return kept | U(kRayStrayed);
  return select(specular, kept, U(kRayDiffuse));
}

}  // namespace sheaf

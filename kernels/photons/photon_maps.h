// Selects the photon map for each vertex of a camera path, and decides which light is path traced.
//
// A camera path reaches its first non-specular surface vertex x by E S* x:
//     PhotonGathering::kAll       the global map at x holds all light that x scatters, except caustics if there is a
//                                 caustic map; the path ends there
//     PhotonGathering::kIndirect  light is sampled at x, and one ray continues from x to hit lights by BSDF sampling.
//                                 All else comes from the maps at x: caustics from the caustic map, if there is one
//     PhotonGathering::kFinal     light is sampled at x, and one ray continues from x, which reaches surfaces by S* y.
//                                 The global map at y holds all light that y scatters, and the path ends there. Light
//                                 that the ray hits by S+ comes from the caustic map at x, if there is one
// With a volume map, paths do not scatter in media. The volume map then holds the light that media scatter along E S* x
// and along the rays of final gathering. Without a volume map, no map covers vertices in media: light is sampled there
// and the path continues. For kIndirect, the maps at x hold everything that the ray from x might hit except lights.
#pragma once

#include "kernels/photons/photon_beam_map.h"
#include "kernels/photons/photon_map.h"
#include "kernels/photons/volume_photon_map.h"
#include "kernels/wave/context.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// Photons in media, as points and as beams. keeps_beams() selects one of both for each medium.
struct VolumePhotonMaps {
  VolumePhotonMap points;
  PhotonBeamMap beams;
};

/// The photon maps of a pass.
struct PhotonMaps {
  PhotonMapView global, caustic;
  PhotonGathering gathering = PhotonGathering::kAll;
  const VolumePhotonMaps* volume = nullptr;  ///< optional: photons in media; see covers_media()

  /// Whether there is a volume map. If not, paths scatter in media.
  bool covers_media() const { return volume != nullptr; }
  /// Whether a path ends at a non-specular vertex, apart from the vertex's specular lobes. `flags`: of the ray that hit
  /// it.
  template <class L> SHEAF_INLINE Mask<L> ends_at(Uint<L> flags, bool in_medium) const {
    if (in_medium && gathering != PhotonGathering::kIndirect) return Mask<L>(false);
    const Uint<L> needed(gathering == PhotonGathering::kAll ? 0u : std::uint32_t{kRayDiffuse});
    return (flags & needed) == needed;
  }
  /// The maps to query at a non-specular surface; null or empty: none.
  struct SelectedMaps {
    const PhotonMapView *first, *second;
  };
  SelectedMaps maps_at(std::uint32_t flags) const {
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
  /// Whether the volume map holds the light that media scatter towards a ray. Otherwise another map at the ray's origin
  /// holds it.
  bool gathers_volume(std::uint32_t flags) const {
    return gathering != PhotonGathering::kIndirect || (flags & kRayDiffuse) == 0;
  }
  /// Whether a map holds the light that reaches x through specular surfaces only.
  bool hold_caustics() const {
    return gathering == PhotonGathering::kIndirect || (gathering == PhotonGathering::kFinal && !caustic.empty());
  }
};

/// Whether a map already holds the light that a ray has hit, as a caustic: since the last non-specular surface, the
/// path has scattered specularly only. `scatter_pdf`: see RadianceState.
template <class L> SHEAF_INLINE Mask<L> is_caustic(const StageContext& context, Uint<L> flags, Float<L> scatter_pdf) {
  using U = Uint<L>;
  if (!context.gathers_photons() || !context.photon_maps().hold_caustics()) return Mask<L>(false);
  return ((flags & U(kRayDiffuse | kRayScatteredInMedium)) == U(kRayDiffuse)) & (scatter_pdf == Float<L>(0.0f));
}

/// RayFlags for the history of a path after a vertex. `before`: flags of the ray that hit the vertex; `specular`: lanes
/// that scattered specularly.
template <class L, bool kInMedium>
SHEAF_INLINE Uint<L> history_behind(const StageContext& context, Uint<L> before, Mask<L> specular) {
  using U = Uint<L>;
  const U kept = before & U(kRayHistory);
  if (context.starts_at_lights())
    return kept | (kInMedium ? U(kRayDiffuse) : select(specular, U(kRaySpecular), U(kRayDiffuse)));
  if (kInMedium) return kept | U(kRayScatteredInMedium);
  return select(specular, kept, U(kRayDiffuse));
}

}  // namespace sheaf

// The medium of a ray after it has crossed a surface.
#pragma once

#include "core/soa/lane_array.h"
#include "kernels/wave/path_state.h"
#include "scene/surfaces/shape.h"
#include "scene/tables/exterior_medium.h"

namespace sheaf {

/// The surface that a ray crosses, and when.
template <class L> struct BoundaryCrossing {
  typename L::Uint boundary;  ///< ShapeRow::boundary
  typename L::Uint instance;  ///< of the surface, or kNone
  typename L::Float time;     ///< of the path, in [0, 1]
};

/// The media outside of boundaries that may depend on instance and time, in the lanes of `lanes`.
template <class L>
[[gnu::noinline]] Uint<L> exterior_media(const SceneView& scene, const BoundaryCrossing<L>& at, Mask<L> lanes) {
  const LaneArray<Uint<L>> boundary(at.boundary), instance(at.instance);
  const LaneArray<Float<L>> time(at.time);
  LaneArray<Uint<L>> medium(Uint<L>(0u));
  for_each_lane(mask_bits(lanes), [&](int lane) {
    medium[lane] = exterior_medium(scene.media, boundary[lane], instance[lane], time[lane]);
  });
  return medium.load();
}

/// Replaces the medium in `flags` (RayState::flags) by the one that a ray in `direction` enters through a surface with
/// geometric normal `ng`, both in world space. Surfaces without a boundary leave `flags` unchanged.
template <class L>
SHEAF_INLINE Uint<L> medium_behind(const SceneView& scene, const BoundaryCrossing<L>& at, Vec3<L> ng, Vec3<L> direction,
                                   Uint<L> flags) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto crossing = at.boundary != U(kNone);
  if (!any(crossing)) return flags;
  const auto inwards = dot(ng, direction) < F(0.0f);
  const U row = select(crossing, at.boundary, U(0u));
  U exterior = gather_member<L>(scene.media.boundaries, &BoundaryRow::exterior, row);
  if (scene.media.surroundings != nullptr) [[unlikely]]
    exterior = exterior_media<L>(scene, at, crossing);
  const U medium = select(inwards, gather_member<L>(scene.media.boundaries, &BoundaryRow::interior, row), exterior);
  constexpr std::uint32_t kOthers = (1u << kRayMediumShift) - 1u;
  return select(crossing, (flags & U(kOthers)) | (medium << kRayMediumShift), flags);
}

}  // namespace sheaf

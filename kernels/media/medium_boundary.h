// The medium of a ray after it has crossed a surface.
#pragma once

#include "kernels/wave/path_state.h"
#include "scene/tables/shape.h"

namespace sheaf {

/// Replaces the medium in `flags` (RayState::flags) by the one that a ray in `direction` enters through a surface with
/// geometric normal `ng`, both in world space. `boundary`: ShapeRow::boundary; kNone leaves `flags` unchanged.
template <class L>
SHEAF_INLINE Uint<L> medium_behind(const SceneView& scene, Uint<L> boundary, Vec3<L> ng, Vec3<L> direction,
                                   Uint<L> flags) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto crossing = boundary != U(kNone);
  if (!any(crossing)) return flags;
  const auto inwards = dot(ng, direction) < F(0.0f);
  const U row = select(crossing, boundary, U(0u));
  const U medium = select(inwards, gather_member<L>(scene.media.boundaries, &BoundaryRow::interior, row),
                          gather_member<L>(scene.media.boundaries, &BoundaryRow::exterior, row));
  constexpr std::uint32_t kOthers = (1u << kRayMediumShift) - 1u;
  return select(crossing, (flags & U(kOthers)) | (medium << kRayMediumShift), flags);
}

}  // namespace sheaf

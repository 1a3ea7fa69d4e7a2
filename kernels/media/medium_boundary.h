// What medium a ray is in once it has crossed a surface.
#pragma once

#include "kernels/wave/path_state.h"
#include "scene/tables/shape.h"

namespace sheaf {

/// `flags` (RayState::flags) with the medium that a ray in `direction` enters through a surface of geometric normal
/// `ng`, both in world space; `boundary`: ShapeRow::boundary. Surfaces that are no boundary change nothing.
template <class L>
SHEAF_INLINE Uint<L> medium_behind(const SceneView& scene, Uint<L> boundary, Vec3<L> ng, Vec3<L> direction,
                                   Uint<L> flags) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto crossing = boundary != U(kNone);
  if (!any(crossing)) return flags;
  const auto inwards = dot(ng, direction) < F(0.0f);
  const U row = select(crossing, boundary, U(0u));
  const U medium = select(inwards, gather_member<L>(scene.boundaries, &BoundaryRow::interior, row),
                          gather_member<L>(scene.boundaries, &BoundaryRow::exterior, row));
  constexpr std::uint32_t kOthers = (1u << kRayMediumShift) - 1u;
  return select(crossing, (flags & U(kOthers)) | (medium << kRayMediumShift), flags);
}

}  // namespace sheaf

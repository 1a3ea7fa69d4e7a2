// A vertex as the choice of lights sees it: where it is made, and where the ray that left it finds a light. Both must
// take the same choice for as probable, or else the weights of light and BSDF sampling do not add up to one.
#pragma once

#include "core/octahedral.h"
#include "kernels/lights/light_select.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// A vertex on a surface with shading normal `ns`, which is rounded as the path will remember it: lights near the
/// horizon see the difference (tests/kernels/test_light_choice.cpp).
template <class L> SHEAF_INLINE LightSampleContext<L> surface_receiver(Vec3<L> p, Vec3<L> ns) {
  return {p, decode_octahedral<L>(encode_octahedral<L>(ns))};
}

/// The vertex that `ray` has left. `normal`: RadianceState::normal; `distance_since_vertex`: see
/// Wave::distance_since_vertex.
template <class L>
SHEAF_INLINE LightSampleContext<L> light_sample_context(const RayState<L>& ray, Uint<L> normal,
                                                        Float<L> distance_since_vertex) {
  using U = Uint<L>;
  const auto in_medium = (ray.flags & U(kRayFromMedium)) != U(0u);
  return {ray.origin - ray.direction * distance_since_vertex,
          select<L>(in_medium, Vec3<L>{}, decode_octahedral<L>(normal))};
}

}  // namespace sheaf

// A vertex as light sampling sees it: where a light is sampled, and where a ray from the vertex hits a light. Both must
// give the same probability of the light and the same pdf; otherwise the MIS weights of light and BSDF sampling do not
// add up to 1.
#pragma once

#include "core/sampling/octahedral.h"
#include "kernels/lights/light_select.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// A surface vertex with shading normal `ns`, rounded as the path stores it. Otherwise selection probabilities of
/// lights near the horizon would differ (tests/kernels/lights/test_light_choice.cpp).
template <class L> SHEAF_INLINE LightSampleContext<L> surface_receiver(Vec3<L> p, Vec3<L> ns) {
  return {p, decode_octahedral<L>(encode_octahedral<L>(ns))};
}

/// The vertex that `ray` started from. `normal`: RadianceState::normal. `distance_since_vertex`: see
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

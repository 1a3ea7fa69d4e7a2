// Specular chains of camera paths, which manifold next-event estimation and BSDF sampling both find. Which chains these
// are follows from the path alone:
//
//   A connected chain starts at a non-specular surface vertex of a camera path, then scatters at one to kMaxChainLength
//   vertices, all of them specular and on casters (CausticCasters), and ends on an area light.
//
// For these, the emission stage multiplies what BSDF sampling finds by chain_bsdf_weight(), and manifold connections
// are weighted by the rest. All other light is found as without connections: longer chains, chains over rough or
// textured glass, and chains that end in the environment.
//
// The state of the chain behind the last non-specular vertex is kept in the ray's bits of kRayHistory:
//   0                     camera path without a non-specular vertex
//   1 + k                 k specular vertices on casters since the last non-specular one
//   kUnconnectedChain         any other chain
#pragma once

#include "core/soa/lane_array.h"
#include "kernels/caustics/casters.h"
#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

inline constexpr std::uint32_t kUnconnectedChain = 7;
static_assert(1 + kMaxChainLength < kUnconnectedChain);

/// The state in RayState::flags.
template <class L> SHEAF_INLINE Uint<L> chain_state(Uint<L> flags) {
  using U = Uint<L>;
  return ((flags >> 3) & U(1u)) | ((flags >> 5) & U(6u));
}

/// The bits of RayState::flags for a state.
template <class L> SHEAF_INLINE Uint<L> chain_bits(Uint<L> state) {
  using U = Uint<L>;
  return ((state & U(1u)) << 3) | ((state & U(6u)) << 5);
}

/// Whether manifold next-event estimation adds the light of an area light that the ray has hit.
template <class L> SHEAF_INLINE Mask<L> is_connected_chain(const StageContext& context, Uint<L> flags) {
  using U = Uint<L>;
  if (!context.connects_caustics()) return Mask<L>(false);
  const U state = chain_state<L>(flags);
  return (U(1u) < state) & (state < U(kUnconnectedChain));
}

/// A surface vertex of a chain.
template <class L> struct ChainVertex {
  Vec3<L> ng;                  ///< geometric normal, unit length
  typename L::Mask specular;   ///< a delta lobe scatters the path
  typename L::Mask refracted;  ///< the path crosses the surface
};

/// Adds the state behind a surface vertex to the flags of the new ray. Updates Wave::chain_starts of the paths.
template <class L>
void follow_chain(const StageContext& context, Wave& wave, const Slot* slots, int count, const ChainVertex<L>& vertex,
                  RayState<L>& ray) {
  using U = Uint<L>;
  const CausticCasters& casters = context.caustic_casters();
  const U on_caster = make_lanes<U>([&](int lane) SHEAF_LAMBDA_INLINE {
    const HitState<Scalar>& hit = wave.hits.row(slots[lane]);
    return casters.is_caster(hit.shape, hit.instance) ? 1u : 0u;
  });
  const U state = chain_state<L>(wave.rays.gather<L>(slots).flags);
  const auto has_start = state != U(0u), has_room = state < U(1u + std::uint32_t{kMaxChainLength});
  const auto extends = has_start & has_room & (on_caster != U(0u));
  const U behind_delta = select(state == U(0u), state, select(extends, state + U(1u), U(kUnconnectedChain)));
  ray.flags |= chain_bits<L>(select(vertex.specular, behind_delta, U(1u)));
  // Record the starts, and the lobes of specular vertices
  ChainStartState<L> start = wave.chain_starts.gather<L>(slots);
  start.origin = select<L>(vertex.specular, start.origin, ray.origin);
  start.direction = select<L>(vertex.specular, start.direction, ray.direction);
  start.cosine = select(vertex.specular, start.cosine, abs(dot(vertex.ng, ray.direction)));
  const LaneArray<U> states(state);
  const U bit = make_lanes<U>([&](int lane) SHEAF_LAMBDA_INLINE { return 1u << (states[lane] + 31u) % 32u; });
  start.refracted = select(vertex.specular, start.refracted | select(vertex.refracted, bit, U(0u)), U(0u));
  wave.chain_starts.scatter<L>(slots, count, start);
}

}  // namespace sheaf

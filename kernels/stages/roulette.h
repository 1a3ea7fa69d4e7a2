// Russian roulette (PBR 2.2.4).
//
// Camera paths are terminated at random only when their throughput is below 0.5, and survivors have at least 0.5. The
// usual value of 1 traces fewer rays, but increases noise so much that the same error takes longer (bench/README.md).
// Survivors among photons have 1, since photon map estimates are best with photons of equal power.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// Throughput, relative to the start of the path, below which Russian roulette terminates camera paths. Shadow rays in
/// media have a threshold of their own (kernels/media/density_tracking.h).
inline constexpr float kSurfaceRouletteThreshold = 0.5f;
/// Maximum survival probability, so that paths between perfect mirrors end.
inline constexpr float kLargestSurvival = 0.99f;

/// Survival probability by throughput over `divisor`, without the factor that eta_scale removes; 1 below depth
/// rr_depth.
template <class L>
SHEAF_INLINE Float<L> survival_by_throughput(const StageContext& context, const PathState<L>& path, Float<L> divisor) {
  using F = Float<L>;
  const auto exempt = path.depth() < Uint<L>(static_cast<std::uint32_t>(context.integrator.roulette_depth()));
  const F threshold(!context.starts_at_lights() ? kSurfaceRouletteThreshold : 1.0f);
  const F survival = min(max_component(path.beta) * path.eta_scale / (divisor * threshold), F(kLargestSurvival));
  return select(exempt, F(1.0f), survival);
}

/// Applies Russian roulette. Returns the survivors, whose throughput is divided by `survival`.
template <class L> SHEAF_INLINE Mask<L> roulette(PathState<L>& path, Float<L> survival, Float<L> u) {
  using F = Float<L>;
  const auto survives = u < survival;
  path.beta = path.beta * select(survives, F(1.0f) / survival, F(1.0f));
  return survives;
}

}  // namespace sheaf

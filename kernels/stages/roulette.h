// Russian roulette: which paths go on, and with how much more weight.
//
// A path from the camera is played for once its throughput has fallen below a half, so that those that go on have a
// half at least: bringing each path back to 1, as is common, traces fewer rays but has so much more noise that the same
// error takes longer (bench/README.md). Photons are brought back to 1, since estimates from a map are best where they
// are alike.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/path_state.h"

namespace sheaf {

/// Throughput, over that of the path's start, below which paths from the camera are played for.
inline constexpr float kPlayedBelow = 0.5f;
/// Roulette keeps at most this share, so that paths between perfect mirrors end.
inline constexpr float kLargestSurvival = 0.99f;

/// The probability with which paths survive: from depth rr_depth on by their throughput over `divisor`, what eta_scale
/// holds taken out.
template <class L>
SHEAF_INLINE Float<L> survival_by_throughput(const StageContext& context, const PathState<L>& path, Float<L> divisor) {
  using F = Float<L>;
  const auto exempt = path.depth() < Uint<L>(static_cast<std::uint32_t>(context.integrator.roulette_depth()));
  const F least(context.photons == nullptr ? kPlayedBelow : 1.0f);
  const F survival = min(max_component(path.beta) * path.eta_scale / (divisor * least), F(kLargestSurvival));
  return select(exempt, F(1.0f), survival);
}

/// Returns who survives with these probabilities; they are weighted by the inverse.
template <class L> SHEAF_INLINE Mask<L> roulette(PathState<L>& path, Float<L> survival, Float<L> u) {
  using F = Float<L>;
  const auto survives = u < survival;
  path.beta = path.beta * select(survives, F(1.0f) / survival, F(1.0f));
  return survives;
}

}  // namespace sheaf

// Moments of next-event estimation by the number of light candidates; see kernels/guiding/candidate_moments.h.
#pragma once

#include "core/color/float4.h"
#include "core/soa/lane_array.h"
#include "kernels/guiding/guide_record.h"
#include "kernels/lights/light_weight.h"
#include "kernels/wave/wave.h"

#include <bit>

namespace sheaf {

/// Resampling weights with the MIS weights of each number of candidates. `weight`: with that of kMaxComparedCandidates.
/// `pdf_ratio`: see TransmittanceItem, for kMaxComparedCandidates.
template <class L> SHEAF_INLINE Spectrum<L> weights_by_count(typename L::Float weight, typename L::Float pdf_ratio) {
  using F = Float<L>;
  const F ratio = min(pdf_ratio, F(1e15f));
  const F unweighted = weight * (F(1.0f) + ratio * ratio);
  const auto with = [&](int count) SHEAF_LAMBDA_INLINE {
    const F other = ratio * F(static_cast<float>(kMaxComparedCandidates) / static_cast<float>(count));
    return unweighted / (F(1.0f) + other * other);
  };
  return {with(kCandidateCounts[0]), with(kCandidateCounts[1]), with(kCandidateCounts[2]), weight};
}

/// Moments of next-event estimation at a vertex if its shadow ray is unoccluded, from the weights of all candidates.
template <class L> SHEAF_INLINE void moments_of(const CandidateWeights<L>& w, Spectrum<L>& mean, Spectrum<L>& excess) {
  using F = Float<L>;
  constexpr auto kAll = static_cast<float>(kMaxComparedCandidates);
  // (1 / kAll) / P(the candidate was kept)
  const F factor = w.sum.c3 / (max(w.kept.c3, F(1e-37f)) * F(kAll));
  mean = w.kept * factor;
  const F minus(-1.0f);
  const Spectrum<L> same = w.kept * w.kept * factor;
  const Spectrum<L> others = w.kept * (w.sum + w.kept * minus) * (factor / F(kAll - 1.0f));
  const auto fraction = [](int i) { return Float<L>(1.0f / static_cast<float>(kCandidateCounts[i])); };
  const Spectrum<L> fractions{fraction(0), fraction(1), fraction(2), fraction(3)};
  excess = others + fractions * (same + others * minus) + mean * mean * minus;
}

/// Records candidate `index` of a tile of vertices. `taken`: lanes where it replaces the kept one.
template <class L>
SHEAF_INLINE void try_candidate(const StageContext& context, Wave& wave, const Slot* slots, int column, int count,
                                typename L::Float weight, typename L::Float pdf_ratio, typename L::Mask taken,
                                int index) {
  using F = Float<L>;
  // Add the candidate's weights
  const Spectrum<L> weights = weights_by_count<L>(weight, pdf_ratio);
  CandidateWeights<L> w{weights, weights};
  if (index > 0) {
    w = wave.candidate_weights.template load<L>(column);
    w.sum = w.sum + weights;
    w.kept = select<L>(taken, weights, w.kept);
  }
  wave.candidate_weights.template store<L>(column, w);
  // Count the shadow rays that this number of candidates would have
  if (std::has_single_bit(static_cast<unsigned>(index + 1)))
    context.training_samples().count_vertices(std::countr_zero(static_cast<unsigned>(index + 1)), count,
                                              std::popcount(mask_bits((w.sum.c3 > F(0.0f)) & L::first(count))));
  if (index + 1 < kMaxComparedCandidates) return;
  // Keep the moments until the shadow ray is traced
  Spectrum<L> mean, excess;
  moments_of<L>(w, mean, excess);
  const LaneRows<L, Spectrum> means(mean), excesses(excess);
  for (int lane = 0; lane < count; ++lane) {
    PathMoments<Scalar>& row = wave.moments.row(slots[lane]);
    row.pending = means[lane];
    row.pending_excess = excesses[lane];
  }
}

/// Adds the pending moments of a path whose last shadow ray is unoccluded. `found`: the ray's contribution, spectral
/// lanes added up.
inline void add_unoccluded_moments(Wave& wave, Slot slot, float found) {
  PathMoments<Scalar>& row = wave.moments.row(slot);
  if (!(row.pending.c3 > 0.0f)) return;
  const float fraction = found / row.pending.c3;
  row.radiance = row.radiance + row.pending * fraction;
  row.excess = row.excess + row.pending_excess * (fraction * fraction);
}

/// Adds light that a path has found without candidates, spectral lanes added up.
inline void add_common_moments(Wave& wave, Slot slot, float found) {
  PathMoments<Scalar>& row = wave.moments.row(slot);
  row.radiance = row.radiance + Spectrum4(found);
}

/// Adds emission that a path has hit, spectral lanes added up, for each number of candidates.
template <class L>
void add_emission_moments(Wave& wave, const Slot* slots, std::uint32_t lanes, const Spectrum<L>& found) {
  const LaneRows<L, Spectrum> rows(found);
  for_each_lane(lanes, [&](int lane) {
    PathMoments<Scalar>& row = wave.moments.row(slots[lane]);
    row.radiance = row.radiance + rows[lane];
  });
}

}  // namespace sheaf

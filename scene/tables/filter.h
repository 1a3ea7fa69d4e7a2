// Pixel reconstruction filters, sampled by importance (Ernst, Stamminger and Greiner, "Filter Importance Sampling",
// 2006): every camera sample belongs to one pixel, is placed with density |f|, and weighs the sign of f.
#pragma once

#include "core/vec.h"
#include "scene/description/description.h"

#include <array>

namespace sheaf {

/// The filter's value at distance `x` from the pixel's centre along one axis; zero beyond its radius. Not normalised.
double evaluate_filter(const FilterDescription& filter, double x);
/// Half of the filter's width in pixels.
double filter_radius(const FilterDescription& filter);

/// The inverse cumulative distribution of |f| along one axis, as bins of equal probability.
struct FilterTable {
  static constexpr int kBins = 2048;
  std::array<float, kBins + 1> edges{};  ///< offsets from the pixel's centre, ascending
  std::array<float, kBins> weight{};     ///< per axis: (mean sign of f in the bin) (integral of |f|) / (integral of f)

  template <class L> struct Offset {
    typename L::Float position, weight;
  };

  /// Offset along one axis for a uniform number u in [0, 1).
  template <class L> SHEAF_INLINE Offset<L> sample(typename L::Float u) const {
    using F = typename L::Float;
    const F scaled = u * F(static_cast<float>(kBins));
    const auto bin = to_uint(scaled);
    const F t = scaled - to_float(bin);
    const F lower = gather(edges.data(), bin), upper = gather(edges.data() + 1, bin);
    return {lerp(t, lower, upper), gather(weight.data(), bin)};
  }
};

/// Throws SceneError if a size is not positive and finite.
FilterTable make_filter_table(const FilterDescription& filter);

}  // namespace sheaf

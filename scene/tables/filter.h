// Pixel reconstruction filters, used in one of two ways (FilterMode). Weighted: samples lie evenly in their pixel, and
// count in every pixel whose filter reaches them, by its value there over the sum of these values. By importance
// (Ernst, Stamminger and Greiner, "Filter Importance Sampling", 2006): every sample belongs to one pixel, is placed
// with density |f|, and weighs the sign of f.
#pragma once

#include "core/vec.h"
#include "scene/description/description.h"

#include <algorithm>
#include <array>
#include <cmath>

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

/// Where the samples of a pixel lie that weigh in every pixel within reach: evenly in the pixel, or in the middle of it
/// if the filter is narrower. Throws like make_filter_table().
FilterTable make_placement_table(const FilterDescription& filter);

/// A filter's values along one axis, for samples that weigh in every pixel within reach.
class FilterWeights {
 public:
  FilterWeights() = default;
  explicit FilterWeights(const FilterDescription& filter);

  /// How many pixels further, along each axis, a sample may still count than in its own.
  int reach() const { return reach_; }
  /// Half of the filter's width in pixels.
  float radius() const { return radius_; }
  /// The filter at distance `x`, at most the radius, from a pixel's centre; linear between kSteps values. The value in
  /// the middle is 1.
  float at(float x) const {
    const float place = std::fabs(x) * steps_per_pixel_;
    const int step = std::min(static_cast<int>(place), kSteps - 1);
    const float below = values_[static_cast<std::size_t>(step)], above = values_[static_cast<std::size_t>(step) + 1];
    return below + std::min(place - static_cast<float>(step), 1.0f) * (above - below);
  }

 private:
  static constexpr int kSteps = 1024;
  std::array<float, kSteps + 1> values_{};
  float radius_ = 0, steps_per_pixel_ = 0;
  int reach_ = 0;
};

}  // namespace sheaf

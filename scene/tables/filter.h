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
#include <cstring>
#include <vector>

namespace sheaf {

/// The filter's value at distance `x` from the pixel's centre along one axis; zero beyond its radius. Not normalised.
double evaluate_filter(const FilterDescription& filter, double x);
/// Half of the filter's width in pixels.
double filter_radius(const FilterDescription& filter);

/// The inverse cumulative distribution of |f| along one axis, as bins of equal probability; boxes need none.
struct FilterTable {
  static constexpr int kBins = 2048;
  float box_radius = 0;                  ///< of a box filter, otherwise 0
  std::array<float, kBins + 1> edges{};  ///< offsets from the pixel's centre, ascending
  std::array<float, kBins> weight{};     ///< per axis: (mean sign of f in the bin) (integral of |f|) / (integral of f)

  template <class L> struct Offset { typename L::Float position, weight; };

  /// Offset along one axis for a uniform number u in [0, 1).
  template <class L> SHEAF_INLINE Offset<L> sample(typename L::Float u) const {
    using F = typename L::Float;
    if (box_radius > 0.0f) return {fma(u, F(2.0f * box_radius), F(-box_radius)), F(1.0f)};
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
  /// Most numbers that across() writes: those of the largest radius of make_filter_table(), 64.
  static constexpr int kMaxPixels = 136;

  FilterWeights() = default;
  /// Throws like make_filter_table().
  explicit FilterWeights(const FilterDescription& filter);

  /// How many pixels further, along each axis, a sample may still count than in its own.
  int reach() const { return reach_; }
  /// How many numbers across() writes: at least 2 reach() + 1, a multiple of kRegister.
  int length() const { return length_; }
  /// What a sample at `offset`, in [-1/2, 1/2], from its pixel's centre counts in the pixel k - reach() further, for
  /// each `out`[k], k in [0, length()); 0 where the pixel's centre is farther away than the filter's radius. Linear
  /// between kSteps values per pixel. The filter's value in the middle is 1.
  void across(float offset, double* out) const {
    const float place = std::clamp(offset + 0.5f, 0.0f, 1.0f) * kSteps;
    const int step = std::min(static_cast<int>(place), kSteps - 1);
    const float* const below = values_.data() + static_cast<std::size_t>(step) * static_cast<std::size_t>(length_);
    const float t = place - static_cast<float>(step);
    Floats away = Floats{0, 1, 2, 3, 4, 5, 6, 7} - (static_cast<float>(reach_) + offset);
    for (int k = 0; k < length_; k += kRegister, away += static_cast<float>(kRegister)) {
      Floats a, b;
      std::memcpy(&a, below + k, sizeof a);
      std::memcpy(&b, below + length_ + k, sizeof b);
      const Floats value = ((away <= radius_) & (away >= -radius_)) ? a + t * (b - a) : Floats{};
      const Doubles values = __builtin_convertvector(value, Doubles);
      std::memcpy(out + k, &values, sizeof values);
    }
  }

  static constexpr int kRegister = 8;

 private:
  static constexpr int kSteps = 256;
  using Floats [[gnu::vector_size(kRegister * sizeof(float))]] = float;
  using Doubles [[gnu::vector_size(kRegister * sizeof(double))]] = double;

  /// kSteps + 1 rows of `length_` numbers: row i is that of the offset i / kSteps - 1/2.
  std::vector<float> values_;
  float radius_ = 0;
  int reach_ = 0, length_ = 0;
};

}  // namespace sheaf

// Pixel filters, applied in one of two ways (FilterMode). Weighted: samples are uniform in their pixel and count in
// every pixel whose filter covers them, weighted by the filter's value over the sum of these values. Filter importance
// sampling (Ernst, Stamminger and Greiner, "Filter Importance Sampling", 2006): each sample belongs to one pixel, is
// placed with density |f|, and is weighted by the sign of f.
#pragma once

#include "core/io/error.h"
#include "core/math/vec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

namespace sheaf {

/// A pixel reconstruction filter; sizes in pixels.
struct PixelFilter {
  enum class Kind { kBox, kTent, kGaussian, kMitchell, kCatmullRom, kLanczos } kind = Kind::kBox;
  float radius = 0.5f;               ///< box, tent; other filters derive it from the parameters below
  float stddev = 0.5f;               ///< Gaussian; truncated at 4 standard deviations
  float b = 1.0f / 3, c = 1.0f / 3;  ///< mitchell; radius 2
  float lobes = 3;                   ///< lanczos; equals the radius
};

/// Application of the pixel filter.
enum class FilterMode {
  kWeighted,    ///< each sample counts in every pixel whose filter covers it
  kImportance,  ///< filter importance sampling: each sample counts in one pixel
};

/// Maximum radius, in pixels. Every sample is added to all pixels within its filter's radius.
inline constexpr double kMaxFilterRadius = 64;

/// Throws SceneError at `where` unless the radius, in pixels, is positive and at most kMaxFilterRadius.
void check_filter_radius(double radius, const SourceLocation& where);

/// The filter's value at distance `x` from the pixel's center along one axis; zero beyond its radius. Not normalized.
double evaluate_filter(const PixelFilter& filter, double x);
/// The filter's radius in pixels.
double filter_radius(const PixelFilter& filter);

/// Number of pixels on each side of a sample's own in which it may count with FilterMode::kWeighted, along each axis.
/// Throws SceneError if the radius is not positive and finite.
int filter_reach(const PixelFilter& filter);

/// Inverse cdf of |f| along one axis, as bins of equal probability; not needed for boxes.
struct FilterTable {
  static constexpr int kBins = 2048;
  float box_radius = 0;                  ///< radius of a box filter, otherwise 0
  std::array<float, kBins + 1> edges{};  ///< offsets from the pixel's center, ascending
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
FilterTable make_filter_table(const PixelFilter& filter);

/// Sample placement in a pixel for FilterMode::kWeighted: uniform in the pixel, or in its middle part if the filter is
/// narrower. Throws like make_filter_table().
FilterTable make_placement_table(const PixelFilter& filter);

/// A filter's values along one axis, for FilterMode::kWeighted.
class FilterWeights {
 public:
  /// Maximum length of the output of across(), for the radius kMaxFilterRadius.
  static constexpr int kMaxPixels = 136;

  FilterWeights() = default;
  /// Throws like make_filter_table().
  explicit FilterWeights(const PixelFilter& filter);

  /// Number of pixels on each side of a sample's own in which it may count, along each axis.
  int reach() const { return reach_; }
  /// Length of the output of across(): at least 2 reach() + 1, a multiple of kRegister.
  int length() const { return length_; }
  /// Sets `out`[k], for k in [0, length()), to the weight in pixel k - reach(), relative to the sample's own. `offset`
  /// in [-1/2, 1/2] is the sample's offset from its pixel's center. The weight is 0 beyond the filter's radius, and
  /// linear between kSteps values per pixel. The filter's value at its center is scaled to 1.
  void across(float offset, double* out) const {
    const float cell = std::clamp(offset + 0.5f, 0.0f, 1.0f) * kSteps;
    const int step = std::min(static_cast<int>(cell), kSteps - 1);
    const float* const below = values_.data() + static_cast<std::size_t>(step) * static_cast<std::size_t>(length_);
    const float t = cell - static_cast<float>(step);
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

  /// kSteps + 1 rows of `length_` numbers; row i is for the offset i / kSteps - 1/2.
  std::vector<float> values_;
  float radius_ = 0;
  int reach_ = 0, length_ = 0;
};

}  // namespace sheaf

// How alike the noise of pixels near each other is.
#pragma once

#include "kernels/denoise/plane.h"

#include <array>
#include <cstddef>
#include <cstdlib>

namespace sheaf {

/// The correlation of the noise of two pixels, by the offset from one to the other: 1 at no offset. A picture whose
/// samples count in every pixel under the reconstruction filter has that of the filter with itself; where each counts
/// in one pixel it is 0 but for no offset.
class NoiseCorrelation {
 public:
  /// Offsets of more columns or rows than this are taken to be uncorrelated.
  static constexpr int kReach = 3;

  /// Every pixel has noise of its own.
  NoiseCorrelation() { values_[index(0, 0)] = 1; }
  /// What two halves of the samples show: their difference is noise alone. `variance` is that of the mean of one half,
  /// above 0 wherever halves differ. All are extended. What lies within three standard deviations of its estimate
  /// from 0 is 0.
  NoiseCorrelation(const Planes3& half, const Planes3& other, const Planes3& variance);

  /// Between -1 and 1.
  float operator()(int dx, int dy) const {
    return std::abs(dx) <= kReach && std::abs(dy) <= kReach ? values_[index(dx, dy)] : 0.0f;
  }

 private:
  static constexpr int kSide = 2 * kReach + 1;
  static std::size_t index(int dx, int dy) { return static_cast<std::size_t>((dy + kReach) * kSide + dx + kReach); }

  std::array<float, kSide * kSide> values_{};
};

}  // namespace sheaf

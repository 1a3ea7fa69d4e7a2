// Correlation of the noise of nearby pixels.
#pragma once

#include "kernels/denoise/plane.h"

#include <array>
#include <cstddef>
#include <cstdlib>

namespace sheaf {

/// Correlation of the noise of two pixels by their offset; 1 at offset 0. If samples count in every pixel under the
/// pixel filter, it is the filter's autocorrelation. If each sample counts in one pixel, it is 0 except at offset 0.
class NoiseCorrelation {
 public:
  /// Offsets with more columns or rows than this are assumed to be uncorrelated.
  static constexpr int kReach = 3;

  /// Uncorrelated noise.
  NoiseCorrelation() { values_[index(0, 0)] = 1; }
  /// Estimates the correlation from the difference of two halves of the samples, which consists only of noise.
  /// `variance`: variance of the mean of one half, above 0 wherever the halves differ. All planes have extended
  /// borders. Estimates within three standard deviations of 0 are set to 0.
  NoiseCorrelation(const Planes3& half, const Planes3& other, const Planes3& variance);

  /// Correlation in [-1, 1].
  float operator()(int dx, int dy) const {
    return std::abs(dx) <= kReach && std::abs(dy) <= kReach ? values_[index(dx, dy)] : 0.0f;
  }

 private:
  static constexpr int kSide = 2 * kReach + 1;
  static std::size_t index(int dx, int dy) { return static_cast<std::size_t>((dy + kReach) * kSide + dx + kReach); }

  std::array<float, kSide * kSide> values_{};
};

}  // namespace sheaf

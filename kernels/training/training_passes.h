// Training passes of path guiding: camera samples of the whole frame that only train the guide. Each pass is guided by
// what the previous ones have learned. Their images are discarded, because the guide must not depend on the samples of
// the final image that it guides. The first kComparedPasses passes also estimate the gain of guiding (guiding_gain())
// and choose the number of light candidates (choose_candidates()).
#pragma once

#include "kernels/training/guiding_mode.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// One training pass. The pixels of a pass are evenly distributed over the frame.
struct TrainingPass {
  /// Each participating pixel takes the pairs [first_pair, first_pair + pairs) of sets of samples.
  std::uint32_t first_pair = 0, pairs = 0;
  /// kComparedSamples in the passes that are compared. Later passes take single samples of more pixels, from which the
  /// guide learns more.
  std::uint32_t set_samples = 1;
  /// Every `column_stride`-th pixel of every `row_stride`-th row participates.
  int column_stride = 1, row_stride = 1;

  /// Number of samples per participating pixel.
  std::uint32_t samples() const { return 2 * pairs * set_samples; }
  /// Number of participating columns and rows of a frame.
  int columns(int width) const { return (width + column_stride - 1) / column_stride; }
  int rows(int height) const { return (height + row_stride - 1) / row_stride; }
  bool operator==(const TrainingPass&) const = default;
};

/// Passes for a render of `samples` samples per pixel, whose mode is not kOff; empty for renders too short to benefit.
/// The first two are equally large. Together they take at most 3/16 of the samples of the render, apart from rounding
/// in frames of few pixels.
std::vector<TrainingPass> training_passes(int width, int height, std::uint32_t samples, GuidingMode mode);

/// Whether a render with training passes is long and large enough for GuidingMode::kAuto and for a comparison of light
/// candidates.
bool is_comparison_worthwhile(int width, int height, std::uint32_t samples);

/// Whether the first training passes also compare light candidates, to choose their number.
bool wants_candidate_comparison(const IntegratorSettings& integrator, int width, int height, std::uint32_t samples);

/// Number of camera samples of all passes.
std::uint64_t training_samples(int width, int height, std::span<const TrainingPass> passes);

}  // namespace sheaf

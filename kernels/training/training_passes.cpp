// Plans the training passes of path guiding.
#include "kernels/training/training_passes.h"

#include "kernels/training/guiding_gain.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Camera samples of training: three per pixel of the frame, within these bounds. With kAuto it does not depend on the
/// number of samples, so that a longer render of the same frame has the same guide. Otherwise training takes at least
/// the fraction kTrainingFraction of the samples.
constexpr double kPerPixel = 3, kTrainingFraction = 0.0625, kMinTraining = 1 << 15, kMaxTraining = 1 << 19;
/// Samples of the first pass: one per four pixels, within these bounds. The second is equally large, and every further
/// one twice as large as the one before, except for the last, which takes the rest.
constexpr double kMinPass = 1 << 12, kMaxPass = 1 << 16;
/// Maximum fraction of the samples of a render that training takes.
constexpr double kMaxTrainingFraction = 3.0 / 16;
/// Minimum samples per pixel of renders that train, and of those with kAuto. kAuto also requires kMinAutoPixels,
/// because two passes of fewer pixels give no reliable estimate of the gain.
constexpr std::uint32_t kMinTrained = 8, kMinAutoTrained = 16;
constexpr double kMinAutoPixels = 1 << 14;

}  // namespace

std::vector<TrainingPass> training_passes(int width, int height, std::uint32_t samples, GuidingMode mode) {
  const bool is_auto = mode == GuidingMode::kAuto;
  const double pixels = static_cast<double>(width) * height;
  if (samples < kMinTrained || (is_auto && !is_comparison_worthwhile(width, height, samples))) return {};
  const double fraction = is_auto ? 0 : kTrainingFraction * samples;
  const double requested = std::clamp(std::max(kPerPixel, fraction) * pixels, kMinTraining, kMaxTraining);
  const double total = std::min(requested, kMaxTrainingFraction * samples * pixels);
  std::vector<TrainingPass> passes;
  std::uint32_t first = 0;
  double size = std::min(std::clamp(pixels / 4, kMinPass, kMaxPass), total / 4);
  // The last pass takes what is left, unless that is less than half of what it should have
  for (double left = total; left >= size / 2;) {
    size = std::min(size, left);
    left -= size;
    // Sample some of the pixels with one pair of sets, or all of them with several
    TrainingPass pass;
    pass.first_pair = first;
    pass.set_samples = passes.size() < kComparedPasses ? kComparedSamples : 1;
    const double pairs = size / pixels / (2 * pass.set_samples);
    pass.pairs = std::max(1u, static_cast<std::uint32_t>(pairs));
    const double pixels_apart = 1 / std::min(pairs, 1.0);
    pass.row_stride = static_cast<int>(std::sqrt(pixels_apart));
    pass.column_stride = static_cast<int>(std::ceil(pixels_apart / pass.row_stride));
    passes.push_back(pass);
    first += pass.pairs;
    if (passes.size() > 1) size *= 2;
  }
  return passes;
}

bool is_comparison_worthwhile(int width, int height, std::uint32_t samples) {
  return samples >= kMinAutoTrained && static_cast<double>(width) * height >= kMinAutoPixels;
}

bool wants_candidate_comparison(const IntegratorSettings& integrator, int width, int height, std::uint32_t samples) {
  return !integrator.candidates && integrator.strategy != LightStrategy::kBsdfOnly &&
         is_comparison_worthwhile(width, height, samples);
}

std::uint64_t training_samples(int width, int height, std::span<const TrainingPass> passes) {
  std::uint64_t sum = 0;
  for (const TrainingPass& pass : passes)
    sum += static_cast<std::uint64_t>(pass.columns(width)) * static_cast<std::uint64_t>(pass.rows(height)) *
           pass.samples();
  return sum;
}

}  // namespace sheaf

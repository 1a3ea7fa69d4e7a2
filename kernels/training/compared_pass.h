// Results of a training pass, from which a render decides about guiding and about light candidates.
#pragma once

#include "core/color/spectrum.h"
#include "kernels/guiding/candidate_moments.h"

#include <array>
#include <cstdint>
#include <vector>

namespace sheaf {

/// Number of samples in a set. The samples of a set are stratified among themselves, as those of the image are, because
/// that lowers the error of some estimators more than that of others.
inline constexpr std::uint32_t kComparedSamples = 4;

/// Two independent sets of samples for each pixel of a task.
struct ComparedTask {
  /// Radiance of the samples of each set, all components added up: those of a pixel, then those of the next.
  std::array<std::vector<float>, 2> radiance;
  /// Estimates of the squared radiance of the same samples, for each of kCandidateCounts; empty unless the pass
  /// compares them.
  std::array<std::vector<Spectrum4>, 2> squared_radiance;
};

/// The samples of a training pass.
struct ComparedPass {
  std::vector<ComparedTask> tasks;
  std::uint64_t rays = 0;  ///< traced for these samples, of all kinds

  // If the pass compares numbers of light candidates:
  std::uint64_t light_vertices = 0;                                      ///< that sample lights
  std::array<std::uint64_t, std::size(kCandidateCounts)> shadow_rays{};  ///< for each of kCandidateCounts
};

/// Errors are relative to the squared mean radiance of their task, which counts as at least a fraction of that of the
/// frame. Means exclude the brightest samples, so that fireflies do not hide the error around them.
struct PassBrightness {
  double of_frame = 0;          ///< squared; 0: the pass holds no light
  std::vector<double> of_task;  ///< squared

  explicit PassBrightness(const ComparedPass& pass);
};

/// Fraction of the pixels with the largest errors that estimates exclude: the error of a few bright pixels cannot be
/// estimated reliably.
inline constexpr double kTrimmedFraction = 0.001;

/// Mean without the largest values. `left_out`: the fraction that is excluded. Reorders `values`.
double trimmed_mean(std::vector<float>& values, double left_out = kTrimmedFraction);

/// Number of groups of pixels, each of which the jackknife excludes once.
inline constexpr std::size_t kJackknifeGroups = 16;

/// Standard error of an estimate by the jackknife (Efron and Stein 1981). `without`: the estimates without each group.
double jackknife_error(const std::array<double, kJackknifeGroups>& without);

}  // namespace sheaf

#include "kernels/training/candidate_choice.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr std::size_t kCounts = std::size(kCandidateCounts);
/// Minimum gain of more than one candidate.
constexpr double kMinCandidateGain = 1.05;

using ByCount = std::array<double, kCounts>;

/// Sums of the errors of pixels: squared, and relative to the brightness of the task.
struct ErrorSums {
  ByCount squared{}, relative{};

  /// Logarithm of the geometric mean of both.
  double logarithm(std::size_t i) const { return 0.5 * (std::log(squared[i]) + std::log(relative[i])); }
};

/// Squared error of a pixel by the number of candidates.
struct PixelError {
  std::array<float, kCounts> squared;
  float per_brightness;  ///< 1 / squared brightness of its task
  std::uint32_t group;

  /// The largest error with any number of candidates, by which pixels are excluded.
  float largest() const {
    return std::max(std::abs(squared.front()), std::abs(squared.back())) * std::sqrt(per_brightness);
  }
};

float lane(const Spectrum4& s, std::size_t i) { return (&s.c0)[i]; }

/// The errors of all pixels but those with the largest ones.
std::vector<PixelError> pixel_errors(const ComparedPass& pass, const PassBrightness& brightness) {
  std::vector<PixelError> errors;
  for (std::size_t task = 0; task < pass.tasks.size(); ++task) {
    const auto& [radiance, squared] = pass.tasks[task];
    for (std::size_t i = 0; i < radiance[0].size(); ++i) {
      // The variance with kMaxComparedCandidates, plus the difference of the squared radiance with other numbers
      PixelError error;
      const float difference = radiance[0][i] - radiance[1][i];
      for (std::size_t k = 0; k < kCounts; ++k) {
        const float first = lane(squared[0][i], k) - lane(squared[0][i], kCounts - 1);
        const float second = lane(squared[1][i], k) - lane(squared[1][i], kCounts - 1);
        error.squared[k] = 0.5f * (difference * difference + first + second);
      }
      error.per_brightness = static_cast<float>(1 / brightness.of_task[task]);
      error.group = static_cast<std::uint32_t>(errors.size() / kComparedSamples % kJackknifeGroups);
      errors.push_back(error);
    }
  }
  const auto kept = static_cast<std::ptrdiff_t>(std::ceil(static_cast<double>(errors.size()) * (1 - kTrimmedFraction)));
  const auto smaller = [](const PixelError& a, const PixelError& b) { return a.largest() < b.largest(); };
  std::nth_element(errors.begin(), errors.begin() + std::max<std::ptrdiff_t>(kept - 1, 0), errors.end(), smaller);
  errors.resize(static_cast<std::size_t>(kept));
  return errors;
}

/// Number of rays with each number of candidates, candidates included.
ByCount costs_of(const ComparedPass& pass, double cost) {
  ByCount costs;
  for (std::size_t i = 0; i < kCounts; ++i)
    costs[i] = static_cast<double>(pass.rays - pass.shadow_rays.back() + pass.shadow_rays[i]) +
               cost * static_cast<double>(pass.light_vertices) * (kCandidateCounts[i] - 1);
  return costs;
}

}  // namespace

double candidate_cost(const SceneView& scene) {
  // Measured over whole renders; see bench/README.md.
  constexpr double kOneLight = 0.08, kMap = 0.2, kFewLights = 0.2, kManyLights = 0.32;
  constexpr std::uint32_t kMany = 32;
  const LightView& lights = scene.lights;
  if (lights.bounded_count >= kMany) return kManyLights;
  if (lights.envmap.columns != nullptr) return kMap;
  return lights.count == 1 ? kOneLight : kFewLights;
}

CandidateChoice choose_candidates(const ComparedPass& pass, double cost) {
  const PassBrightness brightness(pass);
  if (!(brightness.of_frame > 0) || pass.light_vertices == 0) return {};
  // Add up the errors of each group of pixels
  std::array<ErrorSums, kJackknifeGroups> groups;
  ErrorSums all;
  for (const PixelError& error : pixel_errors(pass, brightness))
    for (std::size_t k = 0; k < kCounts; ++k)
      for (ErrorSums* sums : {&groups[error.group], &all}) {
        sums->squared[k] += double{error.squared[k]} / brightness.of_frame;
        sums->relative[k] += double{error.squared[k]} * double{error.per_brightness};
      }
  // Compare error times cost with that of one candidate, with all pixels and without each group
  const ByCount costs = costs_of(pass, cost);
  CandidateChoice choice;
  double best = 1;
  for (std::size_t k = 1; k < kCounts; ++k) {
    const auto logarithm = [&](const ErrorSums& sums) {
      return sums.logarithm(0) - sums.logarithm(k) + std::log(costs[0] / costs[k]);
    };
    const double gain = logarithm(all);
    std::array<double, kJackknifeGroups> without{};
    for (std::size_t group = 0; group < kJackknifeGroups; ++group) {
      ErrorSums others = all;
      for (std::size_t i = 0; i < kCounts; ++i) {
        others.squared[i] -= groups[group].squared[i];
        others.relative[i] -= groups[group].relative[i];
      }
      without[group] = logarithm(others);
    }
    if (!std::isfinite(gain)) continue;
    choice.gains[k] = std::exp(gain);
    // A comparison with a value that is not a number is false.
    if (gain < std::log(kMinCandidateGain) || !(gain >= 2 * jackknife_error(without)) || choice.gains[k] < best)
      continue;
    best = choice.gains[k];
    choice.count = kCandidateCounts[k];
  }
  return choice;
}

}  // namespace sheaf

#include "kernels/passes/guiding_gain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace sheaf {

namespace {

/// Time per ray of guided paths over that of others.
constexpr double kGuidedRay = 1.1;
/// Share of the pixels whose error is left out: the error of a few bright pixels is known too badly.
constexpr double kLeftOut = 0.001;
/// Lower bound on the brightness that errors are relative to, as a share of that of the frame, squared.
constexpr double kDarkest = 0.01;
/// Minimum gain of a guide that is used. The gain of more samples is smaller than that of two, because stratification
/// reduces the error of unguided paths more.
constexpr double kMinGain = 1.25;

/// Number of groups of pixels, each of which the jackknife leaves out once.
constexpr std::size_t kGroups = 16;

struct Mean {
  double sum = 0, count = 0;

  void add(const std::vector<float>& values) {
    sum = std::accumulate(values.begin(), values.end(), sum);
    count += static_cast<double>(values.size());
  }
  double value() const { return count > 0 ? sum / count : 0; }
};

/// Mean without the largest values. Reorders `values`.
double trimmed_mean(std::vector<float>& values) {
  const auto kept = static_cast<std::ptrdiff_t>(std::ceil(static_cast<double>(values.size()) * (1 - kLeftOut)));
  if (kept == 0) return 0;
  const auto end = values.begin() + kept;
  std::nth_element(values.begin(), end - 1, values.end());
  return std::accumulate(values.begin(), end, 0.0) / static_cast<double>(kept);
}

/// Errors of a pass, all in relation to the brightness of the frame.
class Errors {
 public:
  /// `brightness`: of each task, squared.
  Errors(const TrialPass& pass, const std::vector<double>& brightness, double of_frame) {
    for (std::size_t task = 0; task < pass.radiance.size(); ++task) {
      const std::vector<float>& radiance = pass.radiance[task];
      for (std::size_t i = 0; i + 1 < radiance.size(); i += 2) {
        const double difference = double{radiance[i]} - double{radiance[i + 1]};
        squares_.push_back(static_cast<float>(0.5 * difference * difference / of_frame));
        relative_.push_back(static_cast<float>(0.5 * difference * difference / brightness[task]));
      }
    }
  }
  /// Geometric mean of both errors, without the pixels of a group; kGroups: with all pixels.
  double without(std::size_t group) const {
    return std::sqrt(mean_without(squares_, group) * mean_without(relative_, group));
  }

 private:
  static double mean_without(const std::vector<float>& values, std::size_t group) {
    std::vector<float> others;
    others.reserve(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      if (i % kGroups != group) others.push_back(values[i]);
    return trimmed_mean(others);
  }

  std::vector<float> squares_, relative_;
};

}  // namespace

bool GuidingGain::is_significant() const { return ratio >= std::exp(2 * standard_error) && ratio >= kMinGain; }

GuidingGain guiding_gain(const TrialPass& unguided, const TrialPass& guided) {
  // Measure the brightness of the frame and of each task
  Mean frame;
  std::vector<Mean> tasks(unguided.radiance.size());
  for (const TrialPass* pass : {&unguided, &guided})
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      frame.add(pass->radiance[i]);
      tasks[i].add(pass->radiance[i]);
    }
  if (!(frame.value() > 0)) return {};
  const double of_frame = frame.value() * frame.value();
  std::vector<double> brightness;
  for (const Mean& task : tasks) brightness.push_back(task.value() * task.value() + kDarkest * of_frame);
  // Compare error times cost, with all pixels and without each group
  const Errors errors(unguided, brightness, of_frame), guided_errors(guided, brightness, of_frame);
  const double rays = static_cast<double>(unguided.rays) / (static_cast<double>(guided.rays) * kGuidedRay);
  std::array<double, kGroups + 1> logarithms;
  for (std::size_t group = 0; group <= kGroups; ++group) {
    const double error = errors.without(group), guided_error = guided_errors.without(group);
    if (!(error > 0) || !(guided_error > 0)) return {};
    logarithms[group] = std::log(error / guided_error * rays);
  }
  double mean = 0, spread = 0;
  for (std::size_t group = 0; group < kGroups; ++group) mean += logarithms[group] / kGroups;
  for (std::size_t group = 0; group < kGroups; ++group) spread += std::pow(logarithms[group] - mean, 2);
  return {std::exp(logarithms[kGroups]), std::sqrt(spread * (kGroups - 1) / kGroups)};
}

}  // namespace sheaf

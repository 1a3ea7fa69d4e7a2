#include "kernels/passes/trial_pass.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sheaf {

namespace {

/// Lower bound on the brightness that errors are relative to, as a share of that of the frame, squared.
constexpr double kDarkest = 0.01;

struct Mean {
  double sum = 0, count = 0;

  void add(const std::vector<float>& values) {
    sum = std::accumulate(values.begin(), values.end(), sum);
    count += static_cast<double>(values.size());
  }
  double value() const { return count > 0 ? sum / count : 0; }
};

}  // namespace

TrialBrightness::TrialBrightness(const TrialPass& pass) {
  Mean frame;
  std::vector<Mean> tasks(pass.radiance.size());
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    frame.add(pass.radiance[i]);
    tasks[i].add(pass.radiance[i]);
  }
  if (!(frame.value() > 0)) return;
  of_frame = frame.value() * frame.value();
  for (const Mean& task : tasks) of_task.push_back(task.value() * task.value() + kDarkest * of_frame);
}

double trimmed_mean(std::vector<float>& values, double left_out) {
  const auto kept = static_cast<std::ptrdiff_t>(std::ceil(static_cast<double>(values.size()) * (1 - left_out)));
  if (kept == 0) return 0;
  const auto end = values.begin() + kept;
  std::nth_element(values.begin(), end - 1, values.end());
  return std::accumulate(values.begin(), end, 0.0) / static_cast<double>(kept);
}

double jackknife_error(const std::array<double, kTrialGroups>& without) {
  double mean = 0, spread = 0;
  for (const double value : without) mean += value / kTrialGroups;
  for (const double value : without) spread += std::pow(value - mean, 2);
  return std::sqrt(spread * (kTrialGroups - 1) / kTrialGroups);
}

}  // namespace sheaf

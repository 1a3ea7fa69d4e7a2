#include "kernels/training/compared_pass.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sheaf {

namespace {

/// Lower bound on the squared brightness that errors are relative to, as a fraction of that of the frame.
constexpr double kDarkest = 0.01;

}  // namespace

PassBrightness::PassBrightness(const ComparedPass& pass) {
  double sum = 0, count = 0;
  for (const ComparedTask& task : pass.tasks) {
    std::vector<float> values = task.radiance[0];
    values.insert(values.end(), task.radiance[1].begin(), task.radiance[1].end());
    of_task.push_back(trimmed_mean(values));
    sum += of_task.back() * static_cast<double>(values.size());
    count += static_cast<double>(values.size());
  }
  if (!(sum > 0)) return;
  of_frame = std::pow(sum / count, 2);
  for (double& task : of_task) task = task * task + kDarkest * of_frame;
}

double trimmed_mean(std::vector<float>& values, double left_out) {
  const auto kept = static_cast<std::ptrdiff_t>(std::ceil(static_cast<double>(values.size()) * (1 - left_out)));
  if (kept == 0) return 0;
  const auto end = values.begin() + kept;
  std::nth_element(values.begin(), end - 1, values.end());
  return std::accumulate(values.begin(), end, 0.0) / static_cast<double>(kept);
}

double jackknife_error(const std::array<double, kJackknifeGroups>& without) {
  double mean = 0, spread = 0;
  for (const double value : without) mean += value / kJackknifeGroups;
  for (const double value : without) spread += std::pow(value - mean, 2);
  return std::sqrt(spread * (kJackknifeGroups - 1) / kJackknifeGroups);
}

}  // namespace sheaf

#include "kernels/training/guiding_gain.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sheaf {

namespace {

/// Time per ray of guided paths over that of others.
constexpr double kGuidedRay = 1.2;
/// Minimum gain of a guide that is used. The gain of more samples is smaller than that of a set, because stratification
/// reduces the error of unguided paths more.
constexpr double kMinGain = 1.25;
/// Fractions of the worst pixels that estimates exclude. Where a few paths carry most of the error, estimates from two
/// sets of samples depend on this fraction, so the gain must be significant with each of them.
constexpr std::array kLeftOut{kTrimmedFraction, 5 * kTrimmedFraction};
/// Minimum gain after one training pass for which training continues. Gains grow with training: from 1.6 to 2.1 in an
/// interior under a sky.
constexpr double kPromisingGain = 1;

double rays_per_sample(const ComparedPass& pass) {
  double samples = 0;
  for (const ComparedTask& task : pass.tasks)
    samples += static_cast<double>(task.radiance[0].size() + task.radiance[1].size());
  return static_cast<double>(pass.rays) / std::max(samples, 1.0);
}

/// Mean of the set of samples of a pixel that begins at `first`.
double mean_of_set(const std::vector<float>& radiance, std::size_t first) {
  const auto begin = radiance.begin() + static_cast<std::ptrdiff_t>(first);
  return std::accumulate(begin, begin + kComparedSamples, 0.0) / kComparedSamples;
}

/// Errors of a pass, all in relation to the brightness of the frame.
class Errors {
 public:
  /// `of_frame`: the squared brightness of the frame.
  Errors(const ComparedPass& pass, double of_frame) {
    const PassBrightness brightness(pass);
    for (std::size_t task = 0; task < pass.tasks.size(); ++task) {
      const auto& [first, second] = pass.tasks[task].radiance;
      for (std::size_t i = 0; i < first.size(); i += kComparedSamples) {
        const double difference = mean_of_set(first, i) - mean_of_set(second, i);
        squares_.push_back(static_cast<float>(0.5 * difference * difference / of_frame));
        relative_.push_back(static_cast<float>(0.5 * difference * difference / brightness.of_task[task]));
      }
    }
  }
  /// Geometric mean of both errors, without the pixels of a group; kJackknifeGroups: with all pixels.
  double without(std::size_t group, double left_out) const {
    return std::sqrt(mean_without(squares_, group, left_out) * mean_without(relative_, group, left_out));
  }

 private:
  static double mean_without(const std::vector<float>& values, std::size_t group, double left_out) {
    std::vector<float> others;
    others.reserve(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      if (i % kJackknifeGroups != group) others.push_back(values[i]);
    return trimmed_mean(others, left_out);
  }

  std::vector<float> squares_, relative_;
};

}  // namespace

bool GuidingGain::is_significant() const { return ratio >= std::exp(2 * standard_error) && ratio >= kMinGain; }

bool GuidingGain::is_promising() const { return ratio >= kPromisingGain; }

GuidingGain guiding_gain(const ComparedPass& unguided, const ComparedPass& guided) {
  const double of_frame = PassBrightness(unguided).of_frame;
  if (!(of_frame > 0) || !(PassBrightness(guided).of_frame > 0)) return {};
  const Errors errors(unguided, of_frame), guided_errors(guided, of_frame);
  const double rays = rays_per_sample(unguided) / (rays_per_sample(guided) * kGuidedRay);
  GuidingGain smallest{kInfinity, 0};
  for (const double left_out : kLeftOut) {
    // Compare error times cost, with all pixels and without each group
    const auto logarithm = [&](std::size_t group) {
      const double error = errors.without(group, left_out), guided_error = guided_errors.without(group, left_out);
      return error > 0 && guided_error > 0 ? std::log(error / guided_error * rays) : std::nan("");
    };
    std::array<double, kJackknifeGroups> without{};
    for (std::size_t group = 0; group < kJackknifeGroups; ++group) without[group] = logarithm(group);
    const GuidingGain gain{std::exp(logarithm(kJackknifeGroups)), jackknife_error(without)};
    if (!std::isfinite(gain.ratio) || !std::isfinite(gain.standard_error)) return {};
    if (gain.ratio < smallest.ratio) smallest = gain;
  }
  return smallest;
}

}  // namespace sheaf

#include "scene/compile/key_times.h"

#include "scene/tables/motion.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Number of segments for keys that lie at no common multiple of a fraction of the shutter interval.
constexpr int kDefaultSegments = 16;

/// The number of equidistant segments of the shutter interval between which all keys lie.
int segments_of(const std::vector<double>& keys, const ShutterDescription& shutter) {
  constexpr double kTolerance = 1e-4;
  for (int segments = 1; segments <= kMaxMotionSegments; ++segments) {
    const bool fits = std::all_of(keys.begin(), keys.end(), [&](double key) {
      const double at = (key - shutter.open) / (shutter.close - shutter.open) * segments;
      return at <= kTolerance || at >= segments - kTolerance || std::fabs(at - std::round(at)) <= kTolerance;
    });
    if (fits) return segments;
  }
  return kDefaultSegments;
}

}  // namespace

KeyInterval interval_at(const std::vector<double>& keys, double time) {
  const auto after = static_cast<std::size_t>(std::upper_bound(keys.begin(), keys.end(), time) - keys.begin());
  if (after == 0) return {0, 0};
  const std::size_t before = after - 1;
  if (after == keys.size() || keys[before] == time) return {before, before};
  return {before, after, static_cast<float>((time - keys[before]) / (keys[after] - keys[before]))};
}

std::vector<double> step_times(const std::vector<double>& keys, const ShutterDescription& shutter) {
  std::vector<double> times{shutter.open};
  const bool moves = shutter.close > shutter.open && keys.size() > 1;
  const int segments = moves ? segments_of(keys, shutter) : 0;
  for (int i = 1; i <= segments; ++i)
    times.push_back(shutter.open + (shutter.close - shutter.open) * i / static_cast<double>(segments));
  return times;
}

}  // namespace sheaf

#include "scene/compile/key_times.h"

#include "scene/tables/motion.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// The largest distance of a key inside of the interval from the nearest end of one of `segments` equal parts, in
/// parts.
double distance_of_keys(const std::vector<double>& keys, const ShutterDescription& shutter, int segments) {
  double largest = 0;
  for (const double key : keys)
    if (key > shutter.open && key < shutter.close) {
      const double at = (key - shutter.open) / (shutter.close - shutter.open) * segments;
      largest = std::max(largest, std::fabs(at - std::round(at)));
    }
  return largest;
}

}  // namespace

int segments_of_keys(const std::vector<double>& keys, const ShutterDescription& shutter) {
  constexpr double kRounding = 1e-4;  ///< of a part
  constexpr double kClose = 1e-3;     ///< of the interval
  int closest = 1;
  double smallest = 1;
  for (int segments = 1; segments <= kMaxMotionSegments; ++segments) {
    const double distance = distance_of_keys(keys, shutter, segments);
    if (distance <= kRounding) return segments;
    if (smallest > kClose && distance / segments < smallest) closest = segments, smallest = distance / segments;
  }
  return closest;
}

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
  const int segments = moves ? segments_of_keys(keys, shutter) : 0;
  for (int i = 1; i <= segments; ++i)
    times.push_back(shutter.open + (shutter.close - shutter.open) * i / static_cast<double>(segments));
  return times;
}

}  // namespace sheaf

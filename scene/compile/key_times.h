// Times of the keys of shapes that deform, and of motions.
#pragma once

#include "scene/description/motion.h"

#include <cstddef>
#include <vector>

namespace sheaf {

/// The keys between which a time lies.
struct KeyInterval {
  std::size_t before, after;  ///< equal at a key, before the first one and after the last one
  float t = 0;                ///< from 0 at the key before to 1 at the one after
};

/// The interval that contains a time. `keys`: times that increase, at least one.
KeyInterval interval_at(const std::vector<double>& keys, double time);

/// The smallest number of equal parts of the shutter interval between which all keys inside of it lie. If that would
/// exceed kMaxMotionSegments: the smallest with all keys within a thousandth of the interval of the ends of parts, or
/// else the one whose ends are closest to the keys.
int segments_of_keys(const std::vector<double>& keys, const ShutterDescription& shutter);

/// Equidistant times over the shutter at which to tabulate a shape with keys at these times, in segments_of_keys()
/// parts; only the time at which the shutter opens if nothing moves.
std::vector<double> step_times(const std::vector<double>& keys, const ShutterDescription& shutter);

}  // namespace sheaf

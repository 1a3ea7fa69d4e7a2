// Times of the keys of shapes that deform.
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

/// Equidistant times over the shutter at which to tabulate a shape with keys at these times: as many as hit all keys,
/// or a default number if that would take too many; only the time at which the shutter opens if nothing moves.
std::vector<double> step_times(const std::vector<double>& keys, const ShutterDescription& shutter);

}  // namespace sheaf

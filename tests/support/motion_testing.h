// Moving objects for tests.
#pragma once

#include "scene/description.h"

namespace sheaf {

using MotionKeys = std::vector<AnimatedTransform::Key>;

inline MotionId add_motion(Description& d, MotionKeys keys) {
  d.motions.emplace_back(std::move(keys));
  return MotionId{static_cast<std::uint32_t>(d.motions.size() - 1)};
}

/// Moves a shape by these keys in place of its transform.
inline ShapeDescription& move(Description& d, ShapeDescription& shape, MotionKeys keys) {
  shape.motion = add_motion(d, std::move(keys));
  shape.to_world = d.motions.back().reference();
  return shape;
}

/// Opens the shutter.
inline void expose(Description& d, double open, double close, float ramp = 0) { d.shutter = {open, close, ramp}; }

}  // namespace sheaf

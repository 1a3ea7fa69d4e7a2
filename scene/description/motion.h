// Motion of cameras, shapes, instances and lights, and the shutter.
#pragma once

#include <cstdint>

namespace sheaf {

/// Index into Description::motions. An object with a motion has the motion's transform as its transform to world space.
/// The transform in its own description is that of AnimatedTransform::reference().
enum class MotionId : std::uint32_t {};

/// The interval during which the film is exposed, in the unit of AnimatedTransform's keys, usually seconds.
struct ShutterDescription {
  /// If `close` is not greater than `open`, nothing moves: the scene is rendered as it is at `open`.
  double open = 0, close = 0;
  /// Fraction of the interval during which the shutter opens, and then again closes, at constant speed: 0 to 0.5. 0:
  /// the shutter is either open or closed (box).
  float ramp = 0;
};

}  // namespace sheaf

// Transforms to world space that may change over time, as readers hand them on.
#pragma once

#include "core/math/animated_transform.h"
#include "scene/description/motion.h"

#include <optional>
#include <vector>

namespace sheaf {

/// A transform to world space, and how it moves.
struct Placement {
  Transform to_world;                       ///< AnimatedTransform::reference() of the motion, if there is one
  std::optional<AnimatedTransform> motion;  ///< empty: does not move

  Placement() = default;
  explicit Placement(const Transform& transform) : to_world(transform) {}
  /// Throws Error if the transform is singular at its earliest key.
  explicit Placement(AnimatedTransform transform) : to_world(transform.reference()) {
    if (transform.moves()) motion = std::move(transform);
  }

  /// First `local`, then this placement.
  Placement operator*(const Transform& local) const {
    return motion ? Placement(*motion * AnimatedTransform(local)) : Placement(to_world * local);
  }
};

/// Appends the motion of a placement to Description::motions. Returns nothing if it does not move.
inline std::optional<MotionId> add_motion(std::vector<AnimatedTransform>& motions, const Placement& placement) {
  if (!placement.motion) return std::nullopt;
  motions.push_back(*placement.motion);
  return static_cast<MotionId>(motions.size() - 1);
}

}  // namespace sheaf

// Tabulates transforms over the shutter: matrices at equidistant times, as few as keep linear interpolation accurate.
#pragma once

#include "core/math/animated_transform.h"
#include "scene/description/motion.h"
#include "scene/tables/brick_grid.h"
#include "scene/tables/motion.h"

#include <array>
#include <vector>

namespace sheaf {

/// A transform over time, applied after a constant one.
struct Motion {
  const AnimatedTransform& transform;
  Transform before = {};
};

/// The points and directions at which the error of a tabulated motion is measured. At each of them the error is bounded
/// by a fraction of the distance by which that one moves. So it depends on neither the unit of length nor the extent of
/// the scene.
class MotionProbes {
 public:
  /// A point or a direction, in the space that the motion maps to world space.
  struct Probe {
    std::array<double, 4> p;        ///< homogeneous: the last component is 1 for points and 0 for directions
    double max_relative_error = 0;  ///< directions: maximum error as a fraction of the length
  };

  /// Maximum error as a fraction of the motion, of the size of the object, and of the length of a direction.
  static constexpr double kMaxError = 1e-4;

  /// The corners and the center of a box. Their error is also bounded by a fraction of the size of the box in world
  /// space.
  static MotionProbes of_box(const Bounds3f& box);
  /// The three axes, with errors of at most `max_relative_error` of their lengths.
  static MotionProbes of_directions(double max_relative_error = kMaxError);
  /// Adds a point whose error is bounded by the length of its motion alone.
  void add_point(Vec3f p);

  const std::vector<Probe>& probes() const { return probes_; }
  /// The size of the box under a transform; infinite without a box.
  double size_under(const std::array<double, 12>& matrix) const;

 private:
  std::vector<Probe> probes_;
  std::vector<std::array<double, 4>> diagonals_;  ///< of the box; empty: no box
};

/// Tabulates a motion at equidistant times over the shutter: at as few as keep the errors at the probes within their
/// bounds, and at most at kMaxMotionSegments + 1. If none does, at the largest number, or at the largest whose times
/// include the keys, whichever is more accurate. A single matrix if they do not differ in single precision, or if the
/// shutter does not open. Throws SceneError if a matrix is singular or too extreme.
std::vector<MotionStepRow> tabulate_motion(const Motion& motion, const MotionProbes& probes,
                                           const ShutterDescription& shutter);

/// The steps of an object in the space of `steps` whose rest pose is `rest`: each step maps from there to where
/// `steps` place the object. Linear interpolation preserves this. Throws SceneError if a matrix is too extreme.
std::vector<MotionStepRow> steps_from_rest(const std::vector<MotionStepRow>& steps, const std::array<float, 12>& rest);

}  // namespace sheaf

// Transforms that change over time: keys, interpolated by polar decomposition (Shoemake and Duff 1992, "Matrix
// Animation and Polar Decomposition").
#pragma once

#include "core/math/transform.h"

#include <vector>

namespace sheaf {

/// A unit quaternion x i + y j + z k + w.
struct Quaternion {
  double x = 0, y = 0, z = 0, w = 1;
};

/// The factors of an affine matrix M = T R S: a translation, a rotation, and a symmetric stretch. The stretch has a
/// negative determinant if M reflects.
struct DecomposedTransform {
  std::array<double, 3> translation{};
  Quaternion rotation;
  std::array<std::array<double, 3>, 3> stretch{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// Decomposes an affine transform. Ignores the last row of the matrix.
DecomposedTransform decompose(const Transform& transform);
/// The inverse of decompose(). Throws Error if the matrix is singular.
Transform compose(const DecomposedTransform& parts);
/// Interpolates the translation and the stretch linearly and the rotation spherically, along the shorter arc. `t` lies
/// in [0, 1].
DecomposedTransform interpolate(const DecomposedTransform& a, const DecomposedTransform& b, double t);

/// An affine transform over time: a product of tracks. Each track is interpolated between its keys, and constant before
/// the first and after the last.
class AnimatedTransform {
 public:
  struct Key {
    double time = 0;  ///< s, or whatever unit the scene's shutter has
    Transform value;
  };

  /// The identity at all times.
  AnimatedTransform() = default;
  /// A transform that does not change.
  explicit AnimatedTransform(const Transform& value);
  /// A single track. Sorts the keys by time. Throws Error if `keys` is empty, if a time is not finite, or if two keys
  /// have the same time.
  explicit AnimatedTransform(std::vector<Key> keys);

  /// First `b`, then `*this`, at each time.
  AnimatedTransform operator*(const AnimatedTransform& b) const;

  /// The transform at a time. Throws Error if it is singular, as can happen between keys that differ by a reflection.
  Transform at(double time) const;
  /// The transform at the time of the earliest key. Descriptions of objects that move hold their transforms at that
  /// time.
  Transform reference() const;
  /// Whether the transform changes at all.
  bool moves() const;
  /// The times of all keys at which a track that moves changes its speed, in increasing order.
  std::vector<double> key_times() const;

 private:
  struct TrackKey {
    double time;
    DecomposedTransform value;
  };
  struct Track {
    Transform constant;          ///< if there are no keys
    std::vector<TrackKey> keys;  ///< none, or at least two
    Transform at(double time) const;
  };
  std::vector<Track> tracks_;  ///< the last is applied first
};

}  // namespace sheaf

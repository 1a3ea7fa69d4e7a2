// Axis-aligned boxes.
#pragma once

#include "core/math/vec.h"

#include <algorithm>

namespace sheaf {

/// An axis-aligned box. Empty if a minimum exceeds its maximum.
struct Bounds3f {
  Vec3f min{}, max{};

  /// A box that contains nothing, to be grown.
  static Bounds3f empty() { return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}}; }
  /// Corner `i` in [0, 8): its bits select the maximum along x, y and z.
  Vec3f corner(int i) const {
    return {(i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y, (i & 4) != 0 ? max.z : min.z};
  }
  bool is_empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  /// Extends the box to contain a point or another box.
  void grow(Vec3f p) { grow({p, p}); }
  void grow(const Bounds3f& box) {
    min = {std::min(min.x, box.min.x), std::min(min.y, box.min.y), std::min(min.z, box.min.z)};
    max = {std::max(max.x, box.max.x), std::max(max.y, box.max.y), std::max(max.z, box.max.z)};
  }
};

/// Empty if the boxes do not overlap.
inline Bounds3f intersection(const Bounds3f& a, const Bounds3f& b) {
  return {{std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y), std::max(a.min.z, b.min.z)},
          {std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y), std::min(a.max.z, b.max.z)}};
}

}  // namespace sheaf

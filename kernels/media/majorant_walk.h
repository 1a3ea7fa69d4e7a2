// Walking along a ray from cell to cell of a majorant grid (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for
// Ray Tracing", 1987).
#pragma once

#include "scene/tables/majorant_grid.h"

namespace sheaf {

/// A piece of a ray and a bound on the volume along it.
struct MajorantSegment {
  float t0, t1;  ///< t0 < t1; in lengths of the ray's direction
  float bound;   ///< of the volume's values; may be zero
};

/// The segments of a ray, in order and without gaps: of what lies in the grid's box and, if
/// MajorantGridRow::outside is not zero, of all the rest. To be used as
///
///   MajorantWalk walk(row, origin, direction, t_min, t_max);
///   for (MajorantSegment s; walk.next(s);) ...
///
/// t of the planes between cells is (plane - origin) / direction for each plane anew instead of a running sum, so that
/// nothing drifts: by the rounding of that expression t never decreases. Whatever the ray, there is an end: no more
/// segments than the sum of MajorantGridRow::cells, and two outside.
class MajorantWalk {
 public:
  /// A ray in world space; the direction may have any length. t_max may be infinite, the rest is finite. There are no
  /// segments unless t_min < t_max.
  SHEAF_INLINE MajorantWalk(const MajorantGridRow& row, Vec3f origin, Vec3f direction, float t_min, float t_max)
      : bounds_(row.bounds), t_(t_min), t_max_(t_max), outside_(row.outside) {
    const float* const m = row.world_to_cells;
    float enter = t_min, leave = t_max;
    bool hits = row.bounds != nullptr;
    for (int axis = 0; axis < 3; ++axis) {
      const float d = m[axis] * direction.x + m[4 + axis] * direction.y + m[8 + axis] * direction.z;
      const float o = m[axis] * origin.x + m[4 + axis] * origin.y + m[8 + axis] * origin.z + m[12 + axis];
      // So small a component moves nothing within the box, and its reciprocal might be infinite.
      const bool is_parallel = !(abs(d) > 1e-30f);
      const float inverse = is_parallel ? 0.0f : 1.0f / d;
      hits = hits && (!is_parallel || (o >= row.box_min[axis] && o <= row.box_max[axis]));
      const float a = (row.box_min[axis] - o) * inverse, b = (row.box_max[axis] - o) * inverse;
      enter = max(enter, is_parallel ? enter : min(a, b));
      leave = min(leave, is_parallel ? leave : max(a, b));
      origin_[axis] = o;
      inverse_[axis] = inverse;
      direction_[axis] = is_parallel ? 0.0f : d;
    }
    hits = hits && enter < leave;
    enter_ = hits ? enter : t_max;
    leave_ = hits ? leave : t_max;
    if (outside_ == 0.0f) {
      t_ = enter_;
      t_max_ = leave_;
    }
    if (hits) start_cells(row);
  }

  /// The next segment; false: there is none.
  SHEAF_INLINE bool next(MajorantSegment& segment) {
    if (!(t_ < t_max_)) return false;
    if (t_ < enter_ || t_ >= leave_) {
      segment = {t_, t_ < enter_ ? enter_ : t_max_, outside_};
      t_ = segment.t1;
      return true;
    }
    for (;;) {
      const int axis = t_plane_[0] < t_plane_[1] ? (t_plane_[0] < t_plane_[2] ? 0 : 2)
                                                 : (t_plane_[1] < t_plane_[2] ? 1 : 2);
      const float plane = t_plane_[axis];
      segment.t0 = t_;
      segment.bound = bounds_[index_];
      if (!(plane < leave_)) {
        segment.t1 = t_ = leave_;
        return true;
      }
      index_ += stride_[axis];
      plane_[axis] += step_[axis];
      t_plane_[axis] = plane_[axis] == last_plane_[axis] ? kInfinity : (plane_[axis] - origin_[axis]) * inverse_[axis];
      if (plane > segment.t0) {
        segment.t1 = t_ = plane;
        return true;
      }
    }
  }

 private:
  /// Finds the cell at the box's entry and the planes in front of it.
  SHEAF_INLINE void start_cells(const MajorantGridRow& row) {
    std::int32_t stride = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const float last = static_cast<float>(row.cells[axis] - 1), d = direction_[axis];
      const float at = origin_[axis] + enter_ * d;
      const auto cell = static_cast<std::int32_t>(at > 0.0f ? min(at, last) : 0.0f);
      const auto corner = static_cast<float>(cell);
      index_ += cell * stride;
      stride_[axis] = d > 0.0f ? stride : -stride;
      step_[axis] = d > 0.0f ? 1.0f : -1.0f;
      plane_[axis] = d > 0.0f ? corner + 1.0f : corner;
      // Behind the planes between cells there is only the box's face.
      last_plane_[axis] = d > 0.0f ? last + 1.0f : 0.0f;
      const bool has_plane = d != 0.0f && plane_[axis] != last_plane_[axis];
      t_plane_[axis] = has_plane ? (plane_[axis] - origin_[axis]) * inverse_[axis] : kInfinity;
      stride *= row.cells[axis];
    }
  }

  const float* bounds_;
  std::int32_t index_ = 0;
  float t_, t_max_;
  float enter_, leave_;  ///< of the box; both t_max: the ray misses it
  float outside_;
  float origin_[3], direction_[3], inverse_[3];  ///< in cells; components that are almost zero are zero
  std::int32_t stride_[3];
  float plane_[3], t_plane_[3], step_[3], last_plane_[3];
};

}  // namespace sheaf

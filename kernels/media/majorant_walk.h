// Traversal of a majorant grid along a ray, leaf by leaf.
#pragma once

#include "core/math/vec.h"
#include "scene/tables/majorant_grid.h"

namespace sheaf {

/// A segment of a ray with a bound on the volume.
struct MajorantSegment {
  float t0, t1;  ///< t0 < t1; in units of the direction's length
  float bound;   ///< on the volume's values; may be 0
};

/// Traversal of the box of a majorant grid by a ray.
///
/// The state is a point within the current leaf. The leaf, its size and its exit planes follow from this point and the
/// table of base cells. Leaves can therefore have any size, and the rays in a register can be far apart. The t of a
/// plane is always computed as (plane - origin) / direction, not as a running sum, so errors do not accumulate. When
/// the ray crosses a plane, the point moves beyond it along that axis and is clamped to the old leaf along the others.
/// The point never moves backwards along any axis, and each step crosses a plane. The number of steps is thus at most
/// the number of voxels along the three axes, for any ray.
template <class L> struct LeafWalk {
  using F = Float<L>;
  Vec3<L> origin, direction, inverse;  ///< in voxels; components close to 0 are set to 0
  Vec3<L> position;                    ///< point in the current leaf
  F t, leave;                          ///< current distance, and where the ray leaves the box
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.direction, s.inverse, s.position, s.t, s.leave); }
};

/// The leaf that contains the current point.
template <class L> struct MajorantLeaf {
  Vec3<L> low;                  ///< lowest corner
  Float<L> side;                ///< in voxels
  Float<L> majorant, minorant;  ///< bounds on the volume's values in the leaf
  Vec3<L> t_planes;             ///< distances to the exit planes
  Float<L> t_end;               ///< distance at which the ray leaves the leaf
};

namespace detail {

/// 2^n for each lane, n in [-126, 127] (as two's complement).
template <class L> SHEAF_INLINE Float<L> power_of_two(Uint<L> n) { return bits_float((n + Uint<L>(127u)) << 23); }

}  // namespace detail

/// Starts a traversal for a ray in world space with a direction of any length. t_min must be finite. If `hits` is
/// false, the ray misses the box and there is nothing to traverse.
template <class L>
SHEAF_INLINE LeafWalk<L> start_leaf_walk(const MajorantGridRow& row, Vec3<L> origin, Vec3<L> direction, Float<L> t_min,
                                         Float<L> t_max, Mask<L>& hits) {
  using F = Float<L>;
  LeafWalk<L> walk;
  const float* const m = row.world_to_grid;
  F enter = t_min, leave = t_max;
  hits = Mask<L>(row.bounds != nullptr);
  // Clip the ray, in grid space, by the slabs of the box
  const auto slab = [&](int axis, F& o_out, F& d_out, F& inverse_out) SHEAF_LAMBDA_INLINE {
    const F d = F(m[axis]) * direction.x + F(m[4 + axis]) * direction.y + F(m[8 + axis]) * direction.z;
    const F o = F(m[axis]) * origin.x + F(m[4 + axis]) * origin.y + F(m[8 + axis]) * origin.z + F(m[12 + axis]);
    // Such a small component has no effect within the box, and its reciprocal may be infinite.
    const Mask<L> is_parallel = !(abs(d) > F(1e-30f));
    const F inverse = select(is_parallel, F(0.0f), F(1.0f) / select(is_parallel, F(1.0f), d));
    const F lo(row.box_min[axis]), hi(row.box_max[axis]);
    const Mask<L> within = (o >= lo) & (o <= hi), across = !is_parallel;
    hits = hits & (across | within);
    const F a = (lo - o) * inverse, b = (hi - o) * inverse;
    enter = max(enter, select(is_parallel, enter, min(a, b)));
    leave = min(leave, select(is_parallel, leave, max(a, b)));
    o_out = o;
    d_out = select(is_parallel, F(0.0f), d);
    inverse_out = inverse;
  };
  slab(0, walk.origin.x, walk.direction.x, walk.inverse.x);
  slab(1, walk.origin.y, walk.direction.y, walk.inverse.y);
  slab(2, walk.origin.z, walk.direction.z, walk.inverse.z);
  hits = hits & (enter < leave);
  // Find the first cell
  const auto start = [&](int axis, F o, F d) SHEAF_LAMBDA_INLINE {
    const float end = static_cast<float>(row.cells[axis] << row.base_log2) - 0.5f;
    return min(max(o + enter * d, F(0.0f)), F(end));
  };
  walk.position = {start(0, walk.origin.x, walk.direction.x), start(1, walk.origin.y, walk.direction.y),
                   start(2, walk.origin.z, walk.direction.z)};
  walk.t = select(hits, enter, t_max);
  walk.leave = select(hits, leave, t_max);
  return walk;
}

/// Looks up the leaf at the current point.
template <class L> SHEAF_INLINE MajorantLeaf<L> find_leaf(const MajorantGridRow& row, const LeafWalk<L>& walk) {
  using F = Float<L>;
  using U = Uint<L>;
  const int base_log2 = static_cast<int>(row.base_log2);
  const U x = to_uint(walk.position.x), y = to_uint(walk.position.y), z = to_uint(walk.position.z);
  const U cell = ((z >> base_log2) * U(row.cells[1]) + (y >> base_log2)) * U(row.cells[0]) + (x >> base_log2);
  const U entry = gather(row.entries, cell);
  const U log2 = entry & U((1u << kMajorantSideBits) - 1u);
  MajorantLeaf<L> leaf;
  leaf.side = detail::power_of_two<L>(log2);
  const F inverse_side = detail::power_of_two<L>(U(0u) - log2);
  const auto low_of = [&](F position) SHEAF_LAMBDA_INLINE { return floor(position * inverse_side) * leaf.side; };
  leaf.low = {low_of(walk.position.x), low_of(walk.position.y), low_of(walk.position.z)};
  // Locate the leaf within its base cell. A leaf larger than a base cell begins before it.
  const F per_side = max(F(static_cast<float>(1u << base_log2)) * inverse_side, F(1.0f));
  const U in_base((1u << base_log2) - 1u);
  const auto part_of = [&](U position)
                           SHEAF_LAMBDA_INLINE { return floor(to_float(position & in_base) * inverse_side); };
  const U index =
      (entry >> kMajorantSideBits) + to_uint(fma(fma(part_of(z), per_side, part_of(y)), per_side, part_of(x)));
  const U bounds = gather(&row.bounds->bits, index);
  leaf.majorant = bits_float(bounds & U(0xffff0000u));
  leaf.minorant = bits_float(bounds << 16);
  // 0 is not an exit plane: the first leaves extend to the face of the box.
  const auto plane_of = [&](F low, F o, F d, F inverse) SHEAF_LAMBDA_INLINE {
    const F plane = select(d > F(0.0f), low + leaf.side, low);
    return select((plane == F(0.0f)) | (d == F(0.0f)), F(kInfinity), (plane - o) * inverse);
  };
  leaf.t_planes = {plane_of(leaf.low.x, walk.origin.x, walk.direction.x, walk.inverse.x),
                   plane_of(leaf.low.y, walk.origin.y, walk.direction.y, walk.inverse.y),
                   plane_of(leaf.low.z, walk.origin.z, walk.direction.z, walk.inverse.z)};
  leaf.t_end = min(leaf.t_planes.x, min(leaf.t_planes.y, leaf.t_planes.z));
  return leaf;
}

/// The point at which the traversal continues after a leaf that ends before the box does.
template <class L>
SHEAF_INLINE Vec3<L> position_behind(const MajorantGridRow& row, const LeafWalk<L>& walk, const MajorantLeaf<L>& leaf) {
  using F = Float<L>;
  const auto behind = [&](int axis, F t_plane, F low, F o, F d) SHEAF_LAMBDA_INLINE {
    const F across = select(d > F(0.0f), low + leaf.side, low - F(0.5f));
    // Half a voxel before the upper corner lies in the last voxel, which belongs to one leaf. Leaves may extend beyond
    // the table.
    const F last = min(low + leaf.side, F(static_cast<float>(row.cells[axis] << row.base_log2))) - F(0.5f);
    const F along = min(max(fma(leaf.t_end, d, o), low), last);
    return select(t_plane == leaf.t_end, across, along);
  };
  return {behind(0, leaf.t_planes.x, leaf.low.x, walk.origin.x, walk.direction.x),
          behind(1, leaf.t_planes.y, leaf.low.y, walk.origin.y, walk.direction.y),
          behind(2, leaf.t_planes.z, leaf.low.z, walk.origin.z, walk.direction.z)};
}

/// Iterates over the segments of a ray, in order and without gaps. They cover the grid's box and, if
/// MajorantGridRow::outside is not 0, the rest of the ray. Usage:
///
///   MajorantWalk walk(row, origin, direction, t_min, t_max);
///   for (MajorantSegment s; walk.next(s);) ...
class MajorantWalk {
 public:
  /// A ray in world space with a direction of any length. t_max may be infinite; all else must be finite. There are no
  /// segments unless t_min < t_max.
  SHEAF_INLINE MajorantWalk(const MajorantGridRow& row, Vec3f origin, Vec3f direction, float t_min, float t_max)
      : row_(row), t_(t_min), t_max_(t_max) {
    bool hits;
    walk_ = start_leaf_walk<Scalar>(row, origin, direction, t_min, t_max, hits);
    if (row.outside == 0.0f) {
      t_ = walk_.t;
      t_max_ = walk_.leave;
    }
  }

  /// Returns the next segment; false at the end.
  SHEAF_INLINE bool next(MajorantSegment& segment) {
    if (!(t_ < t_max_)) return false;
    if (t_ < walk_.t || t_ >= walk_.leave) {
      segment = {t_, t_ < walk_.t ? walk_.t : t_max_, row_.outside};
      t_ = segment.t1;
      return true;
    }
    for (;;) {
      const MajorantLeaf<Scalar> leaf = find_leaf<Scalar>(row_, walk_);
      const bool is_last = !(leaf.t_end < walk_.leave);
      segment = {t_, is_last ? walk_.leave : leaf.t_end, leaf.majorant};
      if (!is_last) walk_.position = position_behind<Scalar>(row_, walk_, leaf);
      if (is_last || segment.t1 > segment.t0) {
        t_ = segment.t1;
        return true;
      }
    }
  }

 private:
  const MajorantGridRow& row_;
  /// its t stays at the entry into the box; t_max if the ray misses the box
  LeafWalk<Scalar> walk_;
  float t_, t_max_;
};

}  // namespace sheaf

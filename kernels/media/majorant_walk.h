// Walking along a ray from leaf to leaf of a majorant grid.
#pragma once

#include "core/vec.h"
#include "scene/tables/majorant_grid.h"

namespace sheaf {

/// A piece of a ray and bounds on the volume along it.
struct MajorantSegment {
  float t0, t1;  ///< t0 < t1; in lengths of the ray's direction
  float bound;   ///< of the volume's values; may be zero
};

/// A ray's way through the box of a majorant grid, from leaf to leaf.
///
/// A place within the current leaf is kept along each axis; from it and the table of base cells follow the leaf, its
/// size and the planes where the ray leaves it: nothing else is carried along, so that leaves may be of any size, and
/// registers hold rays that are far apart. t of a plane is (plane - origin) / direction for each plane anew instead of
/// a running sum, so that nothing drifts. Where a plane is crossed, the place along its axis is set to what is behind
/// it, and along the others kept within the leaf that is left: so along no axis does the place ever go back, and each
/// step crosses a plane. Whatever the ray, there is an end: no more steps than the grid's voxels along its three axes.
template <class L> struct LeafWalk {
  using F = Float<L>;
  Vec3<L> origin, direction, inverse;  ///< in voxels; components that are almost zero are zero
  Vec3<L> place;                       ///< in the current leaf
  F t, leave;                          ///< up to where the ray has come, and where it leaves the box
  static constexpr auto fields(auto& s) { return std::tie(s.origin, s.direction, s.inverse, s.place, s.t, s.leave); }
};

/// A leaf that a ray is in.
template <class L> struct MajorantLeaf {
  Vec3<L> low;                  ///< its lowest corner
  Float<L> side;                ///< in voxels
  Float<L> majorant, minorant;  ///< on the volume's values in it
  Vec3<L> t_planes;             ///< where the ray reaches the planes in front of it
  Float<L> t_end;               ///< where it leaves the leaf
};

namespace detail {

/// 2^n for each lane, n in [-126, 127].
template <class L> SHEAF_INLINE Float<L> power_of_two(Uint<L> n) { return bits_float((n + Uint<L>(127u)) << 23); }

}  // namespace detail

/// A walk at its start; for a ray in world space, of a direction of any length. t_min is finite. Where `hits` is false
/// the ray misses the box, and the walk is over.
template <class L>
SHEAF_INLINE LeafWalk<L> start_leaf_walk(const MajorantGridRow& row, Vec3<L> origin, Vec3<L> direction, Float<L> t_min,
                                         Float<L> t_max, Mask<L>& hits) {
  using F = Float<L>;
  LeafWalk<L> walk;
  const float* const m = row.world_to_grid;
  F enter = t_min, leave = t_max;
  hits = Mask<L>(row.bounds != nullptr);
  const auto slab = [&](int axis, F& o_out, F& d_out, F& inverse_out) SHEAF_LAMBDA_INLINE {
    const F d = F(m[axis]) * direction.x + F(m[4 + axis]) * direction.y + F(m[8 + axis]) * direction.z;
    const F o = F(m[axis]) * origin.x + F(m[4 + axis]) * origin.y + F(m[8 + axis]) * origin.z + F(m[12 + axis]);
    // So small a component moves nothing within the box, and its reciprocal might be infinite.
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
  const auto start = [&](int axis, F o, F d) SHEAF_LAMBDA_INLINE {
    const float end = static_cast<float>(row.cells[axis] << row.base_log2) - 0.5f;
    return min(max(o + enter * d, F(0.0f)), F(end));
  };
  walk.place = {start(0, walk.origin.x, walk.direction.x), start(1, walk.origin.y, walk.direction.y),
                start(2, walk.origin.z, walk.direction.z)};
  walk.t = select(hits, enter, t_max);
  walk.leave = select(hits, leave, t_max);
  return walk;
}

/// The leaf that the walk is in.
template <class L> SHEAF_INLINE MajorantLeaf<L> find_leaf(const MajorantGridRow& row, const LeafWalk<L>& walk) {
  using F = Float<L>;
  using U = Uint<L>;
  const int base_log2 = static_cast<int>(row.base_log2);
  const U x = to_uint(walk.place.x), y = to_uint(walk.place.y), z = to_uint(walk.place.z);
  const U cell = ((z >> base_log2) * U(row.cells[1]) + (y >> base_log2)) * U(row.cells[0]) + (x >> base_log2);
  const U entry = gather(row.entries, cell);
  const U log2 = entry & U((1u << kMajorantSideBits) - 1u);
  MajorantLeaf<L> leaf;
  leaf.side = detail::power_of_two<L>(log2);
  const F inverse_side = detail::power_of_two<L>(U(0u) - log2);
  const auto low_of = [&](F place) SHEAF_LAMBDA_INLINE { return floor(place * inverse_side) * leaf.side; };
  leaf.low = {low_of(walk.place.x), low_of(walk.place.y), low_of(walk.place.z)};
  // Where the leaf is a part of its base cell: which one. Leaves wider than that begin before it.
  const F per_side = max(F(static_cast<float>(1u << base_log2)) * inverse_side, F(1.0f));
  const U in_base((1u << base_log2) - 1u);
  const auto part_of = [&](U place) SHEAF_LAMBDA_INLINE { return floor(to_float(place & in_base) * inverse_side); };
  const U index =
      (entry >> kMajorantSideBits) + to_uint(fma(fma(part_of(z), per_side, part_of(y)), per_side, part_of(x)));
  const U bounds = gather(&row.bounds->bits, index);
  leaf.majorant = bits_float(bounds & U(0xffff0000u));
  leaf.minorant = bits_float(bounds << 16);
  // A plane at 0 is no plane: the first leaves reach on to the box's face.
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

/// The place where the walk goes on behind a leaf that ends before the box does.
template <class L>
SHEAF_INLINE Vec3<L> place_behind(const MajorantGridRow& row, const LeafWalk<L>& walk, const MajorantLeaf<L>& leaf) {
  using F = Float<L>;
  const auto behind = [&](int axis, F t_plane, F low, F o, F d) SHEAF_LAMBDA_INLINE {
    const F across = select(d > F(0.0f), low + leaf.side, low - F(0.5f));
    // Half a voxel before the upper corner is in the last voxel, and all of that in one leaf. Leaves may reach beyond
    // the table.
    const F last = min(low + leaf.side, F(static_cast<float>(row.cells[axis] << row.base_log2))) - F(0.5f);
    const F along = min(max(fma(leaf.t_end, d, o), low), last);
    return select(t_plane == leaf.t_end, across, along);
  };
  return {behind(0, leaf.t_planes.x, leaf.low.x, walk.origin.x, walk.direction.x),
          behind(1, leaf.t_planes.y, leaf.low.y, walk.origin.y, walk.direction.y),
          behind(2, leaf.t_planes.z, leaf.low.z, walk.origin.z, walk.direction.z)};
}

/// The segments of a ray, in order and without gaps: of what lies in the grid's box and, if MajorantGridRow::outside is
/// not zero, of all the rest. To be used as
///
///   MajorantWalk walk(row, origin, direction, t_min, t_max);
///   for (MajorantSegment s; walk.next(s);) ...
class MajorantWalk {
 public:
  /// A ray in world space; the direction may have any length. t_max may be infinite, the rest is finite. There are no
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

  /// The next segment; false: there is none.
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
      if (!is_last) walk_.place = place_behind<Scalar>(row_, walk_, leaf);
      if (is_last || segment.t1 > segment.t0) {
        t_ = segment.t1;
        return true;
      }
    }
  }

 private:
  const MajorantGridRow& row_;
  LeafWalk<Scalar> walk_;  ///< its t remains where the ray enters the box; t_max: it misses it
  float t_, t_max_;
};

}  // namespace sheaf

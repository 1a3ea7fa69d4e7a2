// Instances of shape groups: their rows, bounds and transforms. Transforms are generic in the lane policy.
#pragma once

#include "core/math/bounds.h"
#include "scene/tables/instance_transform.h"
#include "scene/tables/shape_rows.h"

namespace sheaf {

/// Makes the row for an instance of a group. Throws SceneError if the transform is unusable; see is_usable_instance().
InstanceRow make_instance(const std::array<float, 12>& to_world, std::uint32_t first_shape, std::uint32_t group);

/// World-space bounds of a box of the group's space.
Bounds3f instance_bounds(const InstanceRow& row, const Bounds3f& box);

/// An instance's transform M with the cofactors of its linear part. The inverse is not stored: its columns are the rows
/// of cofactors over the determinant.
template <class L> struct InstancePlacement {
  Vec3<L> rows[3];  ///< of the linear part of M
  Vec3<L> translation;
  Vec3<L> cofactors[3];  ///< rows of det(M) M^-T
  typename L::Float determinant;

  SHEAF_INLINE explicit InstancePlacement(const InstanceRecord<L>& row) : determinant(row.determinant) {
    const auto* m = row.to_world;
    for (int i = 0; i < 3; ++i) rows[i] = {m[4 * i], m[4 * i + 1], m[4 * i + 2]};
    translation = {m[3], m[7], m[11]};
    for (int i = 0; i < 3; ++i) cofactors[i] = cross(rows[(i + 1) % 3], rows[(i + 2) % 3]);
  }

  SHEAF_INLINE Vec3<L> vector(Vec3<L> v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  SHEAF_INLINE Vec3<L> point(Vec3<L> p) const { return vector(p) + translation; }
  /// Transforms by the inverse transpose, times |det M|; not normalized.
  SHEAF_INLINE Vec3<L> normal(Vec3<L> n) const {
    const Vec3<L> transformed{dot(cofactors[0], n), dot(cofactors[1], n), dot(cofactors[2], n)};
    return transformed * copysign(typename L::Float(1.0f), determinant);
  }
  SHEAF_INLINE Vec3<L> object_point(Vec3<L> p) const {
    const Vec3<L> d = p - translation;
    return (cofactors[0] * d.x + cofactors[1] * d.y + cofactors[2] * d.z) / determinant;
  }
  SHEAF_INLINE Vec3<L> object_vector(Vec3<L> v) const {
    return (cofactors[0] * v.x + cofactors[1] * v.y + cofactors[2] * v.z) / determinant;
  }
  /// A normal in world space to the direction of the normal in the group's space; not normalized.
  SHEAF_INLINE Vec3<L> object_normal(Vec3<L> n) const { return rows[0] * n.x + rows[1] * n.y + rows[2] * n.z; }
  /// point() with the absolute values of all terms.
  SHEAF_INLINE Vec3<L> absolute_point(Vec3<L> p) const {
    const Vec3<L> q = abs(p);
    return Vec3<L>{dot(abs(rows[0]), q), dot(abs(rows[1]), q), dot(abs(rows[2]), q)} + abs(translation);
  }
  /// The inverse times |det M| with the absolute values of all terms, applied to a vector without negative components.
  SHEAF_INLINE Vec3<L> absolute_cofactors(Vec3<L> v) const {
    const Vec3<L> r[3] = {abs(rows[0]), abs(rows[1]), abs(rows[2])};
    return absolute_cross(r[1], r[2]) * v.x + absolute_cross(r[2], r[0]) * v.y + absolute_cross(r[0], r[1]) * v.z;
  }

 private:
  static SHEAF_INLINE Vec3<L> absolute_cross(Vec3<L> a, Vec3<L> b) {
    return {a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x};
  }
};

/// Selects `a` or `b` per lane.
template <class L>
SHEAF_INLINE InstancePlacement<L> select(Mask<L> m, const InstancePlacement<L>& a, const InstancePlacement<L>& b) {
  InstancePlacement<L> out = b;
  for (int i = 0; i < 3; ++i) {
    out.rows[i] = select<L>(m, a.rows[i], b.rows[i]);
    out.cofactors[i] = select<L>(m, a.cofactors[i], b.cofactors[i]);
  }
  out.translation = select<L>(m, a.translation, b.translation);
  out.determinant = select(m, a.determinant, b.determinant);
  return out;
}

}  // namespace sheaf

// Tables of shapes: what kernels gather of them, a row for each lane.
#pragma once

#include "core/record_table.h"
#include "core/vec.h"
#include "scene/tables/none.h"

namespace sheaf {

enum class ShapeKind : std::uint32_t { kMesh, kSphere, kDisk, kCylinder, kLinearCurves, kBsplineCurves, kSdfGrid };

/// Bits of ShapeRecord::flags.
enum ShapeFlags : std::uint32_t {
  kHasNormals = 1,  ///< vertices have normals; else the shape is faceted
  kHasUvs = 2,      ///< vertices have uv; else barycentric coordinates serve as such
};

/// One shape. Those of shape groups follow the others, group by group, in the space of their group. Half a cache line.
template <class L> struct ShapeRecord {
  typename L::Uint kind{};  ///< ShapeKind
  /// Meshes: into SceneView::triangles; quadrics and grids of distances: into SceneView::quadrics; curves: into
  /// SceneView::curve_segments.
  typename L::Uint first_triangle{};
  /// Meshes: into SceneView::vertices; curves: into SceneView::curve_points; grids: into SceneView::sdf_grids.
  typename L::Uint first_vertex{};
  typename L::Uint flags{};     ///< ShapeFlags
  typename L::Uint material{};  ///< into SceneView::materials
  /// Into SceneView::lights, in groups counted from the instance's first; kNone: does not emit.
  typename L::Uint light{kNone};
  typename L::Uint triangle_count{};  ///< curves: of segments; grids: of cells that hold some of the surface
  typename L::Uint boundary{kNone};   ///< into SceneView::boundaries; kNone: the same medium on both sides
  static constexpr auto fields(auto& s) {
    return std::tie(s.kind, s.first_triangle, s.first_vertex, s.flags, s.material, s.light, s.triangle_count,
                    s.boundary);
  }
};
using ShapeRow = ShapeRecord<Scalar>;
static_assert(sizeof(ShapeRow) == 32);

/// A vertex of a mesh, in half a cache line: whoever needs its position needs the rest as well.
template <class L> struct alignas(row_alignment<L>(32)) VertexRecord {
  Vec3<L> position;
  Vec3<L> normal;  ///< unit length; zero without kHasNormals
  Vec2<L> uv;      ///< zero without kHasUvs
  static constexpr auto fields(auto& s) { return std::tie(s.position, s.normal, s.uv); }
};
using VertexRow = VertexRecord<Scalar>;
static_assert(sizeof(VertexRow) == 32);

/// A sphere, disk or cylinder: an affine image of the canonical one (unit sphere around the origin; unit disk at z = 0;
/// side of radius 1 for z in [0, 1]).
template <class L> struct QuadricRecord {
  typename L::Float to_world[12];   ///< rows of the 3x4 matrix
  typename L::Float to_object[12];  ///< its inverse
  typename L::Float normal_sign;    ///< -1 if normals are flipped
  typename L::Float determinant;    ///< |det| of the linear part
  typename L::Float uniform_scale;  ///< the factor, if the linear part is a rotation times a factor; else 0
  EnumIn<L, ShapeKind> kind;        ///< kSphere, kDisk or kCylinder; or kSdfGrid, see there
  static constexpr auto fields(auto& s) {
    return std::tie(s.to_world, s.to_object, s.normal_sign, s.determinant, s.uniform_scale, s.kind);
  }

  SHEAF_INLINE Vec3<L> world_vector(Vec3<L> v) const { return linear(to_world, v); }
  SHEAF_INLINE Vec3<L> world_point(Vec3<L> v) const {
    return linear(to_world, v) + Vec3<L>{to_world[3], to_world[7], to_world[11]};
  }
  SHEAF_INLINE Vec3<L> object_point(Vec3<L> v) const {
    return linear(to_object, v) + Vec3<L>{to_object[3], to_object[7], to_object[11]};
  }
  /// By the inverse transpose; not normalised.
  SHEAF_INLINE Vec3<L> world_normal(Vec3<L> n) const {
    const auto* m = to_object;
    return {m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
            m[2] * n.x + m[6] * n.y + m[10] * n.z};
  }

 private:
  static SHEAF_INLINE Vec3<L> linear(const typename L::Float* m, Vec3<L> v) {
    return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
            m[8] * v.x + m[9] * v.y + m[10] * v.z};
  }
};
using QuadricRow = QuadricRecord<Scalar>;

/// Signed distances at the points of a grid, trilinear in each cell between eight of them; the surface is where they
/// are 0, and they are positive outside. Its quadric has the transform, from where cells are unit cubes and the first
/// point is the origin; of kind kSdfGrid.
template <class L> struct alignas(row_alignment<L>(32)) SdfGridRecord {
  typename L::Uint size_x, size_y, size_z;  ///< points along each axis, two at least
  typename L::Uint layer;                   ///< size_x times size_y
  typename L::Uint first_value;             ///< into SceneView::sdf_values, x fastest
  /// Into SceneView::sdf_cells, pairs of words there, one for each cell with some of the surface: x and y of its least
  /// corner, 16 bits each, and z.
  typename L::Uint first_cell;
  typename L::Uint cell_count;
  typename L::Uint
      smooth;  ///< 1: shading normals pass from cell to cell without a break; 0: they are the geometric ones
  static constexpr auto fields(auto& s) {
    return std::tie(s.size_x, s.size_y, s.size_z, s.layer, s.first_value, s.first_cell, s.cell_count, s.smooth);
  }
};
using SdfGridRow = SdfGridRecord<Scalar>;
static_assert(sizeof(SdfGridRow) == 32);

/// A control point of curves. Four words, read at once.
template <class L> struct alignas(row_alignment<L>(16)) CurvePointRecord {
  Vec3<L> position;
  typename L::Float radius;
  static constexpr auto fields(auto& s) { return std::tie(s.position, s.radius); }
};
using CurvePointRow = CurvePointRecord<Scalar>;
static_assert(sizeof(CurvePointRow) == 16);

/// A group's shapes placed in the world: one cache line.
template <class L> struct alignas(row_alignment<L>(64)) InstanceRecord {
  typename L::Float to_world[12];  ///< rows of the 3x4 matrix
  typename L::Float determinant;   ///< of its linear part; negative if it mirrors
  typename L::Uint first_shape;    ///< of the group; into SceneView::shapes
  typename L::Uint group;          ///< index of the group
  typename L::Uint first_light;    ///< into SceneView::lights
  static constexpr auto fields(auto& s) {
    return std::tie(s.to_world, s.determinant, s.first_shape, s.group, s.first_light);
  }
};
using InstanceRow = InstanceRecord<Scalar>;
static_assert(sizeof(InstanceRow) == 64);

}  // namespace sheaf

// Rows of the tables of shapes, gathered by kernels per lane.
#pragma once

#include "core/math/vec.h"
#include "core/soa/record_table.h"
#include "scene/tables/none.h"

namespace sheaf {

enum class ShapeKind : std::uint32_t { kMesh, kSphere, kDisk, kCylinder, kLinearCurves, kBsplineCurves, kSdfGrid };

/// Bits of ShapeRecord::flags.
enum ShapeFlags : std::uint32_t {
  kHasNormals = 1,  ///< vertices have normals; else the shape is faceted
  kHasUvs = 2,      ///< vertices have uv; else barycentric coordinates are used as uv
  kUntraced = 4,    ///< rays never hit the shape
};
/// The bits from here on: 0, or 1 + the row of a shape that deforms in MotionView::deformations.
inline constexpr int kDeformationShift = 3;

/// One shape. Shapes of groups follow all others, group by group, in their group's space. Half a cache line.
template <class L> struct ShapeRecord {
  typename L::Uint kind{};  ///< ShapeKind
  /// Meshes: into GeometryView::triangles. Quadrics and SDF grids: into GeometryView::quadrics. Curves: into
  /// GeometryView::curve_segments.
  typename L::Uint first_triangle{};
  /// Meshes: into GeometryView::vertices. Curves: into GeometryView::curve_points. SDF grids: into
  /// GeometryView::sdf_grids.
  typename L::Uint first_vertex{};
  typename L::Uint flags{};     ///< ShapeFlags and kDeformationShift
  typename L::Uint material{};  ///< into MaterialView::rows
  /// Into LightView::rows; in groups, relative to the instance's first light. kNone: does not emit.
  typename L::Uint light{kNone};
  /// Curves: number of segments; SDF grids: number of cells that contain the surface
  typename L::Uint triangle_count{};
  typename L::Uint boundary{kNone};  ///< into MediumView::boundaries; kNone: the same medium on both sides
  static constexpr auto fields(auto& s) {
    return std::tie(s.kind, s.first_triangle, s.first_vertex, s.flags, s.material, s.light, s.triangle_count,
                    s.boundary);
  }
};
using ShapeRow = ShapeRecord<Scalar>;
static_assert(sizeof(ShapeRow) == 32);

/// A vertex of a mesh. Half a cache line: position, normal and uv are needed together.
template <class L> struct alignas(row_alignment<L>(32)) VertexRecord {
  Vec3<L> position;
  Vec3<L> normal;  ///< unit length; zero without kHasNormals
  Vec2<L> uv;      ///< zero without kHasUvs
  static constexpr auto fields(auto& s) { return std::tie(s.position, s.normal, s.uv); }
};
using VertexRow = VertexRecord<Scalar>;
static_assert(sizeof(VertexRow) == 32);

/// The tangent of a vertex. Four words, loaded together.
template <class L> struct alignas(row_alignment<L>(16)) TangentRecord {
  Vec3<L> direction;             ///< any length; zero: that of increasing u
  typename L::Float handedness;  ///< see MeshTangent
  static constexpr auto fields(auto& s) { return std::tie(s.direction, s.handedness); }
};
using TangentRow = TangentRecord<Scalar>;
static_assert(sizeof(TangentRow) == 16);

/// A sphere, disk or cylinder as an affine image of the canonical shape: the unit sphere around the origin, the unit
/// disk at z = 0, or the lateral surface of radius 1 for z in [0, 1].
template <class L> struct QuadricRecord {
  typename L::Float to_world[12];   ///< rows of the 3x4 matrix
  typename L::Float to_object[12];  ///< its inverse
  typename L::Float normal_sign;    ///< -1 if normals are flipped
  typename L::Float determinant;    ///< |det| of the linear part
  /// scale factor if the linear part is a scaled rotation, possibly with a reflection; else 0
  typename L::Float uniform_scale;
  EnumIn<L, ShapeKind> kind;  ///< kSphere, kDisk or kCylinder; kSdfGrid: see SdfGridRecord
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
  /// Transforms by the inverse transpose; not normalized.
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

/// Signed distances at grid points, trilinear in each cell. The surface is the zero level set; values are positive
/// outside. The grid's quadric row, of kind kSdfGrid, holds its transform. In object space, cells are unit cubes and
/// the first grid point is the origin.
template <class L> struct alignas(row_alignment<L>(32)) SdfGridRecord {
  typename L::Uint size_x, size_y, size_z;  ///< points along each axis, at least 2
  typename L::Uint layer;                   ///< size_x * size_y
  typename L::Uint first_value;             ///< into GeometryView::sdf_values, x fastest
  /// Into GeometryView::sdf_cells, which has two words for each cell that contains the surface: x and y of its minimum
  /// corner in 16 bits each, and z.
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

/// A control point of curves. Four words, loaded together.
template <class L> struct alignas(row_alignment<L>(16)) CurvePointRecord {
  Vec3<L> position;
  typename L::Float radius;
  static constexpr auto fields(auto& s) { return std::tie(s.position, s.radius); }
};
using CurvePointRow = CurvePointRecord<Scalar>;
static_assert(sizeof(CurvePointRow) == 16);

/// An instance of a shape group. One cache line.
template <class L> struct alignas(row_alignment<L>(64)) InstanceRecord {
  typename L::Float to_world[12];  ///< rows of the 3x4 matrix
  typename L::Float determinant;   ///< of its linear part; negative for reflections
  typename L::Uint first_shape;    ///< first shape of the group in GeometryView::shapes
  typename L::Uint group;          ///< index of the group
  typename L::Uint first_light;    ///< into LightView::rows
  static constexpr auto fields(auto& s) {
    return std::tie(s.to_world, s.determinant, s.first_shape, s.group, s.first_light);
  }
};
using InstanceRow = InstanceRecord<Scalar>;
static_assert(sizeof(InstanceRow) == 64);

}  // namespace sheaf

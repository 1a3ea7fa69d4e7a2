// Light records: the data common to all lights, and the data of single kinds. Kernels gather them with
// core/record_table.h.
#pragma once

#include "core/record_table.h"
#include "core/spectrum.h"
#include "core/vec.h"
#include "scene/tables/light_kind.h"
#include "scene/tables/none.h"

namespace sheaf {

/// Resolution of a volume light's box: cells along the axes, each in [1, 1023].
struct VolumeCells {
  std::uint32_t x = 1, y = 1, z = 1;
};

/// One light. Lights at infinity follow all others. Sixteen words; the meaning of some depends on the kind and is given
/// by the accessors.
template <class L> struct LightRecord {
  using F = typename L::Float;
  using U = typename L::Uint;

  U kind{};            ///< LightKind; see is()
  U shape = U(kNone);  ///< area lights; kVolume: see medium()
  /// kMesh: into triangle_alias and light_triangles. kVolume: into triangle_alias, cells. kSphere, kQuadric: see
  /// quadric().
  U first_triangle{};
  U triangle_count{};
  /// Radiance (W / (m^2 sr)). kPoint, spots, kGoniometric, kProjector: intensity (W / sr). kDirectional: irradiance (W
  /// / m^2). kBeam: power (W). kEnvmap: mean over all directions. kVolume: total emitted intensity, W / sr. A texture
  /// is multiplied by this.
  Spectrum<L> radiance;
  /// kPoint, spots, kGoniometric, kProjector, kBeam, kSphere (centre), kVolume (minimum corner): position, metres.
  /// kDirectional, kSun: unit vector towards the light.
  Vec3<L> position;
  /// Area lights: area in world space; kQuadric: area of the canonical shape; kVolume: see extent(); kBeam: see beam().
  F area{};
  F radius{};            ///< kSphere: radius; kSun: 1 - cosine of its angular radius
  F depth{};             ///< area lights: see set_sides()
  U texture = U(kNone);  ///< into SceneView::textures; kNone: no texture
  U detail{};            ///< see frame(), first_uv(), least_offset() and cells()

  static constexpr auto fields(auto& s) {
    return std::tie(s.kind, s.shape, s.first_triangle, s.triangle_count, s.radiance, s.position, s.area, s.radius,
                    s.depth, s.texture, s.detail);
  }

  SHEAF_INLINE typename L::Mask is(LightKind k) const { return kind == U(static_cast<std::uint32_t>(k)); }
  /// kSphere, kQuadric: into GeometryView::quadrics.
  SHEAF_INLINE U quadric() const { return first_triangle; }
  /// kVolume: into MediumView::rows.
  SHEAF_INLINE U medium() const { return shape; }
  /// kVolume: size of its box, metres.
  SHEAF_INLINE Vec3<L> extent() const { return {area, radius, depth}; }
  /// kBeam: where the light travels, unit length.
  SHEAF_INLINE Vec3<L> beam() const { return extent(); }
  /// Area lights: whether they emit only along their normal. Radiance is then radiant exitance (W / m^2).
  SHEAF_INLINE typename L::Mask is_along_normal() const { return depth > F(0.0f); }
  /// Area lights: whether they also emit on the side opposite to the normal.
  SHEAF_INLINE typename L::Mask is_two_sided() const { return (depth < F(0.0f)) | (depth > F(1.0f)); }
  void set_sides(bool along_normal, bool two_sided) {
    depth = along_normal ? (two_sided ? 2.0f : 1.0f) : (two_sided ? -1.0f : 0.0f);
  }
  void set_extent(Vec3<L> size) { area = size.x, radius = size.y, depth = size.z; }
  /// Spots, kGoniometric, kProjector: into LightView::frames.
  SHEAF_INLINE U frame() const { return detail; }
  /// kMesh with a texture: index of the first triangle in LightView::uvs.
  SHEAF_INLINE U first_uv() const { return detail; }
  /// kSphere, kQuadric: minimum distance by which points are moved off the surface.
  SHEAF_INLINE F least_offset() const { return bits_float(detail); }
};

/// A row of LightView::rows.
using LightRow = LightRecord<Scalar>;
static_assert(sizeof(LightRow) == 64);

/// kVolume: encoding of the cells in LightRecord::detail.
inline VolumeCells volume_cells(const LightRow& light) {
  return {light.detail & 0x3ffu, light.detail >> 10 & 0x3ffu, light.detail >> 20};
}
inline std::uint32_t volume_cells_word(const VolumeCells& cells) { return cells.x | cells.y << 10 | cells.z << 20; }

/// Additional data of lights with an orientation: an affine map to the light's space, where it looks along +z, and
/// parameters of the kind. One cache line.
template <class L> struct alignas(row_alignment<L>(64)) LightFrameRecord {
  Vec3<L> row_x;  ///< row of the 3x4 matrix without its last element
  typename L::Float offset_x{};
  Vec3<L> row_y;
  typename L::Float offset_y{};
  Vec3<L> row_z;
  typename L::Float offset_z{};
  /// kSpot: cutoff angle, radians. kSmoothSpot: its cosine. kProjector: see picture_scale().
  typename L::Float cutoff{};
  /// kSpot: 1 / (cutoff - beam width). kSmoothSpot: 1 / (cosine of the beam width - cutoff). kProjector: see
  /// picture_scale().
  typename L::Float slope{};
  typename L::Float cot_cutoff{};  ///< kSpot with a texture: 1 / tan cutoff. kProjector: see is_even()
  typename L::Float unused{};

  static constexpr auto fields(auto& s) {
    return std::tie(s.row_x, s.offset_x, s.row_y, s.offset_y, s.row_z, s.offset_z, s.cutoff, s.slope, s.cot_cutoff,
                    s.unused);
  }

  /// kProjector: reciprocals of the image's width and height at z = 1.
  SHEAF_INLINE Vec2<L> picture_scale() const { return {cutoff, slope}; }
  void set_picture_scale(Vec2<L> scale) { cutoff = scale.x, slope = scale.y; }
  /// kProjector: see ProjectorDescription::is_even.
  SHEAF_INLINE typename L::Mask is_even() const { return cot_cutoff > typename L::Float(0.0f); }
  /// Transforms a point from world space to the light's space.
  SHEAF_INLINE Vec3<L> local_point(Vec3<L> p) const {
    return {row_x.x * p.x + row_x.y * p.y + row_x.z * p.z + offset_x,
            row_y.x * p.x + row_y.y * p.y + row_y.z * p.z + offset_y,
            row_z.x * p.x + row_z.y * p.y + row_z.z * p.z + offset_z};
  }
  /// Transforms a vector from the light's space to world space.
  SHEAF_INLINE Vec3<L> world_vector(Vec3<L> v) const {
    const Vec3<L> across = cross(row_y, row_z);
    const Vec3<L> adjugate = across * v.x + cross(row_z, row_x) * v.y + cross(row_x, row_y) * v.z;
    return adjugate / dot(row_x, across);
  }
  SHEAF_INLINE typename L::Float determinant() const { return dot(row_x, cross(row_y, row_z)); }
};

/// A row of LightView::frames.
using LightFrameRow = LightFrameRecord<Scalar>;
static_assert(sizeof(LightFrameRow) == 64);

/// Texture coordinates of the three vertices of a light's triangle.
template <class L> struct LightUvRecord {
  Vec2<L> a, b, c;
  Vec2<L> unused;
  static constexpr auto fields(auto& s) { return std::tie(s.a, s.b, s.c, s.unused); }

  /// Interpolates with the barycentric weights `w0`, `w1` and `w2` of the vertices.
  SHEAF_INLINE Vec2<L> at(typename L::Float w0, typename L::Float w1, typename L::Float w2) const {
    return {w0 * a.x + w1 * b.x + w2 * c.x, w0 * a.y + w1 * b.y + w2 * c.y};
  }
};

/// A row of LightView::uvs.
using LightUvRow = LightUvRecord<Scalar>;
static_assert(sizeof(LightUvRow) == 32);

/// One triangle of an area light, with all data for sampling a point on it. Sixteen words: one cache line replaces
/// indirect accesses to indices and vertices.
template <class L> struct LightTriangleRecord {
  Vec3<L> p;                   ///< first vertex; world space
  typename L::Float offset{};  ///< see SurfacePoint::offset; maximum over the triangle
  Vec3<L> edge1;               ///< second vertex - first vertex
  typename L::Float unused1{};
  Vec3<L> edge2;  ///< third vertex - first vertex
  typename L::Float unused2{};
  Vec3<L> normal;  ///< geometric, unit length
  typename L::Float unused3{};

  static constexpr auto fields(auto& s) {
    return std::tie(s.p, s.offset, s.edge1, s.unused1, s.edge2, s.unused2, s.normal, s.unused3);
  }
};

/// A row of LightView::triangles.
using LightTriangleRow = LightTriangleRecord<Scalar>;
static_assert(sizeof(LightTriangleRow) == 64);

}  // namespace sheaf

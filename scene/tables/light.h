// Light records, which kernels gather with core/soa/record_table.h. The files of scene/lights/ declare the data of each
// kind.
#pragma once

#include "core/color/spectrum.h"
#include "core/math/vec.h"
#include "core/soa/record_table.h"
#include "scene/tables/none.h"

namespace sheaf {

/// The kind of a light: its position in scene/lights/list.h, which names the values as kLightKind<MeshLightKind>.
enum class LightKind : std::uint32_t {};

/// Bits of LightRecord::flags.
enum LightFlags : std::uint32_t {
  kEmitsAlongNormal = 1,    ///< area lights: emits only along its normal; radiance is radiant exitance (W / m^2)
  kEmitsOnBothSides = 2,    ///< area lights: also emits on the side opposite to the normal
  kConstantIntensity = 4,   ///< projectors: see ProjectorDescription::is_even
  kMissedByRays = 8,        ///< area lights: rays never hit its shape; only light sampling finds it
  kNeedsTextureQuery = 16,  ///< area lights: its texture or that of its coat is looked up
};
/// The bits of LightRecord::flags from here on: 0, or 1 + the row of the light's coat in LightView::coats.
inline constexpr int kLightCoatShift = 8;

/// A clearcoat over the emission of area lights; see kernels/lights/light_coat.h.
struct LightCoatRow {
  float strength = 0;             ///< in [0, 1]
  std::uint32_t texture = kNone;  ///< of the strength, instead of the number; kNone: none
};

/// Words of LightRecord::payload.
inline constexpr int kLightPayloadWords = 9;

/// One light. Lights at infinity follow all others. Sixteen words: data of all kinds, and those of the light's kind.
template <class L> struct LightRecord {
  using F = typename L::Float;
  using U = typename L::Uint;

  U kind{};              ///< LightKind; see is()
  U flags{};             ///< LightFlags and kLightCoatShift
  U texture = U(kNone);  ///< into SceneView::textures; kNone: no texture
  /// Radiance (W / (m^2 sr)), unless the data of the kind (scene/lights/) state otherwise. A texture is multiplied by
  /// it.
  Spectrum<L> radiance;
  F payload[kLightPayloadWords] = {};  ///< see data()

  static constexpr auto fields(auto& s) { return std::tie(s.kind, s.flags, s.texture, s.radiance, s.payload); }

  SHEAF_INLINE typename L::Mask is(LightKind k) const { return kind == U(static_cast<std::uint32_t>(k)); }
  /// The data of the light's kind, such as data<MeshLightData>(). In lanes of other kinds, their words are
  /// reinterpreted.
  template <template <class> class Data> SHEAF_INLINE Data<L> data() const {
    static_assert(kLeafCount<Data> <= kLightPayloadWords);
    return record_of_words<L, Data>(payload);
  }
  template <template <class> class Data> SHEAF_INLINE void set_data(const Data<L>& data) {
    static_assert(kLeafCount<Data> <= kLightPayloadWords);
    words_of_record<L, Data>(data, payload);
  }
  SHEAF_INLINE typename L::Mask has_flag(LightFlags flag) const { return (flags & U(flag)) != U(0u); }
  SHEAF_INLINE typename L::Mask is_along_normal() const { return has_flag(kEmitsAlongNormal); }
  SHEAF_INLINE typename L::Mask needs_texture_query() const { return has_flag(kNeedsTextureQuery); }
  SHEAF_INLINE typename L::Mask is_two_sided() const { return has_flag(kEmitsOnBothSides); }
};

/// A row of LightView::rows.
using LightRow = LightRecord<Scalar>;
static_assert(sizeof(LightRow) == 64);

/// Space of a light with an orientation: an affine map from world space to a space where the light is at the origin and
/// looks along +z.
template <class L> struct LightFrameRecord {
  Vec3<L> row_x;  ///< row of the 3x4 matrix without its last element
  typename L::Float offset_x{};
  Vec3<L> row_y;
  typename L::Float offset_y{};
  Vec3<L> row_z;
  typename L::Float offset_z{};

  static constexpr auto fields(auto& s) {
    return std::tie(s.row_x, s.offset_x, s.row_y, s.offset_y, s.row_z, s.offset_z);
  }

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
static_assert(sizeof(LightFrameRow) == 48);

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
  Vec3<L> p;                            ///< first vertex; world space
  typename L::Float offset{};           ///< see SurfacePoint::offset; maximum over the triangle
  Vec3<L> edge1;                        ///< second vertex - first vertex
  typename L::Float inverse_length1{};  ///< rectangle lights: 1 / |edge1|
  Vec3<L> edge2;                        ///< third vertex - first vertex
  typename L::Float inverse_length2{};  ///< rectangle lights: 1 / |edge2|
  Vec3<L> normal;                       ///< geometric, unit length
  typename L::Float unused{};

  static constexpr auto fields(auto& s) {
    return std::tie(s.p, s.offset, s.edge1, s.inverse_length1, s.edge2, s.inverse_length2, s.normal, s.unused);
  }
};

/// A row of LightView::triangles.
using LightTriangleRow = LightTriangleRecord<Scalar>;
static_assert(sizeof(LightTriangleRow) == 64);

}  // namespace sheaf

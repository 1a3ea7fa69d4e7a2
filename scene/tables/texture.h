// Textures for kernels: rows, tiled texels and mesh attributes in flat tables.
#pragma once

#include "core/record_table.h"
#include "scene/tables/brick_grid.h"
#include "scene/tables/interpolation.h"
#include "scene/tables/table_bytes.h"

#include <memory>
#include <string>
#include <vector>

namespace sheaf {

enum class TextureKind : std::uint32_t {
  kConstant,
  kBitmap,
  kCheckerboard,
  kGrid,
  kMeshAttribute,
  kVolume,
  kMix,
  kWireframe
};

/// Storage of a texel: one value, or four of which the fourth is 0. Bytes represent [0, 1] (kSrgbByte: sRGB-encoded,
/// decoded before interpolation); floats are linear.
enum class TexelFormat : std::uint8_t { kByte1, kByte4, kSrgbByte1, kSrgbByte4, kFloat1, kFloat4 };

constexpr bool holds_bytes(TexelFormat format) { return format < TexelFormat::kFloat1; }
/// Number of channels used: 1 or 3.
constexpr int texel_channels(TexelFormat format) {
  return format == TexelFormat::kByte1 || format == TexelFormat::kSrgbByte1 || format == TexelFormat::kFloat1 ? 1 : 3;
}

/// One cache line of texels: a tile of 8x8 (single bytes), 4x4 (four bytes or one float) or 2x2 (four floats), row by
/// row. Tiles are stored row by row from the image's lower left corner. The last tiles of rows and columns are padded.
struct alignas(64) TexelTile {
  std::uint8_t bytes[64];
};

/// Tiles are 2^tile_shift texels wide and high.
constexpr int tile_shift(TexelFormat format) {
  if (texel_channels(format) == 1) return holds_bytes(format) ? 3 : 2;
  return holds_bytes(format) ? 2 : 1;
}

/// Maximum number of texels of an image, including padding, so that 32-bit indices of words address them.
inline constexpr std::size_t kMaxTexels = std::size_t{1} << 30;

/// A constant.
struct ConstantRow {
  float rgb[3];  ///< linear Rec.709
  float scalar;  ///< value as a scalar
};
/// An image.
struct BitmapRow {
  std::uint32_t first_tile;  ///< into TextureView::tiles
  std::uint32_t tiles_per_row;
  std::uint32_t width, height;  ///< in texels, without padding; from 1 to kMaxImageSide
  TextureWrap wrap_u, wrap_v;
  TextureFilter filter;
  TexelFormat format;
};
/// Two textures that alternate, or the second as lines on the first.
struct CheckerboardRow {
  std::uint32_t child[2];
  float line_width;  ///< kGrid
};
/// Two textures, mixed by a third.
struct MixRow {
  std::uint32_t child[2];
  std::uint32_t amount;  ///< weight of the second texture; a scalar
};
/// Values stored with meshes.
struct MeshAttributeRow {
  std::uint32_t first_entry;  ///< entry of shape 0 in TextureView::attributes
  float scale;
};
/// A volume grid in world space.
struct VolumeTextureRow {
  std::uint32_t grid;  ///< into TextureView::grids
  float scale;
};
/// The second of two textures along the edges of triangles, the first elsewhere.
struct WireframeRow {
  std::uint32_t child[2];
  /// Entry of shape 0 in TextureView::attributes. The values of a triangle are the distances of its corners from the
  /// opposite edges, in metres or in tenths of the mesh's mean edge length.
  std::uint32_t first_entry;
  /// In the same unit. Up to `inner` only the second texture shows, from `outer` on only the first; inner <= outer.
  float inner, outer;
};

/// One texture.
struct alignas(64) TextureRow {
  TextureKind kind = TextureKind::kConstant;
  float to_uv[6] = {1, 0, 0, 0, 1, 0};  ///< TextureDescription::to_uv
  /// `kind` selects the active member.
  union {
    ConstantRow constant{};
    BitmapRow bitmap;
    CheckerboardRow checkerboard;  ///< kCheckerboard, kGrid
    MeshAttributeRow attribute;
    VolumeTextureRow volume;
    MixRow mix;
    WireframeRow wireframe;
  };
};
static_assert(sizeof(TextureRow) == 64);

/// A mesh attribute of one shape. Four words, loaded together.
template <class L> struct AttributeRecord {
  typename L::Uint first_value{};     ///< into TextureView::attribute_values
  typename L::Uint layout{};          ///< number of channels (1 or 3; 0: the shape lacks the attribute), and kPerFace
  typename L::Uint first_triangle{};  ///< the shape's first triangle in TextureView::triangles
  typename L::Uint triangle_count{};
  static constexpr std::uint32_t kChannels = 3, kPerFace = 4;
  static constexpr auto fields(auto& s) {
    return std::tie(s.first_value, s.layout, s.first_triangle, s.triangle_count);
  }
};
using AttributeEntry = AttributeRecord<Scalar>;
static_assert(sizeof(AttributeEntry) == 16);

/// Meaning of a textured parameter, which determines the conversion of the texture's values.
enum class TextureRole : std::uint32_t {
  kScalar,           ///< a scalar
  kReflectance,      ///< a colour, clamped to [0, 1]
  kUnbounded,        ///< a colour without bounds
  kBurleyLuminance,  ///< a scalar; for colours 0.3 red + 0.6 green + 0.1 blue
};

/// A texture that replaces some of a closure's parameter words.
struct TextureBinding {
  std::uint32_t texture = 0;  ///< into TextureView::rows
  std::uint32_t word = 0;     ///< first word that is replaced
  /// 1: a scalar, the luminance of coloured textures; 4: a colour with 0 in the fourth lane.
  std::uint32_t words = 4;
  TextureRole role = TextureRole::kReflectance;
};
static_assert(sizeof(TextureBinding) == 16);

/// Textures for kernels.
struct TextureView {
  const TextureRow* rows = nullptr;
  const TexelTile* tiles = nullptr;            ///< followed by one tile of padding
  const AttributeEntry* attributes = nullptr;  ///< shape_count entries for each attribute name in use
  /// one or three values per vertex or face; followed by three words of padding
  const float* attribute_values = nullptr;
  const std::uint32_t* triangles = nullptr;  ///< GeometryView::triangles
  std::uint32_t shape_count = 0;
  const BrickGridRow* grids = nullptr;
};

/// Maximum nesting depth of checkerboards, grids, mixes and wireframes. A checkerboard of constants has depth 1.
inline constexpr int kMaxTextureDepth = 8;

/// Owns the textures of a scene.
struct TextureTables {
  /// One row per texture of the description, in order, followed by constants that these refer to.
  std::vector<TextureRow> rows;
  std::unique_ptr<TexelTile[]> tiles;  ///< images one after the other, and one tile of padding
  std::size_t tile_count = 0;          ///< including the padding
  /// Attribute names in use, without duplicates. Until AttributeTable::finish(), MeshAttributeRow::first_entry is an
  /// index into this list.
  std::vector<std::string> attribute_names;
  std::vector<AttributeEntry> attributes;
  std::vector<float> attribute_values;
  std::vector<BrickGrid> grids;
  std::vector<BrickGridRow> grid_rows;  ///< one per grid
  std::vector<std::string> warnings;

  /// `triangles`: GeometryView::triangles. `shape_count`: number of shapes.
  TextureView view(const std::uint32_t* triangles, std::uint32_t shape_count) const {
    return {rows.data(),       tiles.get(),
            attributes.data(), attribute_values.data(),
            triangles,         attributes.empty() ? 0u : shape_count,
            grid_rows.data()};
  }
  /// Memory in bytes.
  std::size_t bytes() const {
    std::size_t sum = bytes_of(rows, attributes, attribute_values) + tile_count * sizeof(TexelTile);
    for (const BrickGrid& grid : grids) sum += grid.bytes();
    return sum;
  }
};

}  // namespace sheaf

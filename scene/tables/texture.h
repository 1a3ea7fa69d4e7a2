// Textures as kernels see them: rows, tiled texels and mesh attributes in flat tables.
#pragma once

#include "core/record_table.h"
#include "scene/tables/brick_grid.h"

#include <memory>

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

/// How a texel is stored: one value or four, of which the fourth is 0; bytes, which stand for 0 .. 1 (kSrgbByte:
/// through the sRGB curve, undone before interpolation), or floats.
enum class TexelFormat : std::uint8_t { kByte1, kByte4, kSrgbByte1, kSrgbByte4, kFloat1, kFloat4 };

constexpr bool holds_bytes(TexelFormat format) { return format < TexelFormat::kFloat1; }
/// Channels that count: 1 or 3.
constexpr int texel_channels(TexelFormat format) {
  return format == TexelFormat::kByte1 || format == TexelFormat::kSrgbByte1 || format == TexelFormat::kFloat1 ? 1 : 3;
}

/// One cache line of texels: a tile of 8x8 (single bytes), 4x4 (four bytes or one float) or 2x2 (four floats), row by
/// row. Tiles follow each other row by row from the picture's lower left corner; the last of a row or column are
/// padded.
struct alignas(64) TexelTile {
  std::uint8_t bytes[64];
};

/// Tiles are 2^tile_shift texels wide and as many high.
constexpr int tile_shift(TexelFormat format) {
  if (texel_channels(format) == 1) return holds_bytes(format) ? 3 : 2;
  return holds_bytes(format) ? 2 : 1;
}

/// Most texels of a picture, padding included: they are reached by 32-bit indices, of words, of either sign.
inline constexpr std::size_t kMaxTexels = std::size_t{1} << 30;

/// The same value everywhere.
struct ConstantRow {
  float rgb[3];  ///< linear Rec.709
  float scalar;  ///< where a number is asked for
};
/// A picture.
struct BitmapRow {
  std::uint32_t first_tile;  ///< into TextureView::tiles
  std::uint32_t tiles_per_row;
  std::uint32_t width, height;  ///< texels, without padding; from 1 to kMaxImageSide
  BitmapDescription::Wrap wrap_u, wrap_v;
  BitmapDescription::Filter filter;
  TexelFormat format;
};
/// Two other textures in turn, or the second as lines on the first.
struct CheckerboardRow {
  std::uint32_t child[2];
  float line_width;  ///< kGrid
};
/// Two other textures, mixed by a third.
struct MixRow {
  std::uint32_t child[2];
  std::uint32_t amount;  ///< of the second, a number
};
/// Values stored with meshes.
struct MeshAttributeRow {
  std::uint32_t first_entry;  ///< of shape 0, into TextureView::attributes
  float scale;
};
/// A grid in the world.
struct VolumeTextureRow {
  std::uint32_t grid;  ///< into TextureView::grids
  float scale;
};
/// The second of two other textures along the edges of triangles, the first elsewhere.
struct WireframeRow {
  std::uint32_t child[2];
  /// Of shape 0, into TextureView::attributes. The values of a triangle are the distances of its corners from the edges
  /// across, in metres or in tenths of the mesh's mean edge.
  std::uint32_t first_entry;
  float inner, outer;  ///< in the same unit: up to where the second is seen alone, from where the first; inner <= outer
};

/// One texture.
struct alignas(64) TextureRow {
  TextureKind kind = TextureKind::kConstant;
  float to_uv[6] = {1, 0, 0, 0, 1, 0};  ///< TextureDescription::to_uv
  /// What holds is told by `kind`.
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

/// A mesh attribute of one shape. Four words, read at once.
template <class L> struct AttributeRecord {
  typename L::Uint first_value{};     ///< into TextureView::attribute_values
  typename L::Uint layout{};          ///< channels (0: the shape has no such attribute, 1 or 3), and kPerFace
  typename L::Uint first_triangle{};  ///< of the shape, into TextureView::triangles
  typename L::Uint triangle_count{};
  static constexpr std::uint32_t kChannels = 3, kPerFace = 4;
  static constexpr auto fields(auto& s) {
    return std::tie(s.first_value, s.layout, s.first_triangle, s.triangle_count);
  }
};
using AttributeEntry = AttributeRecord<Scalar>;
static_assert(sizeof(AttributeEntry) == 16);

/// What a textured parameter stands for, and so what is made of the texture's values.
enum class TextureRole : std::uint32_t {
  kScalar,           ///< a number
  kReflectance,      ///< a colour, clamped to [0, 1]
  kUnbounded,        ///< a colour without limits
  kBurleyLuminance,  ///< a number, of colours 0.3 red + 0.6 green + 0.1 blue
};

/// A texture takes the place of some of a closure's words.
struct TextureBinding {
  std::uint32_t texture = 0;  ///< into TextureView::rows
  std::uint32_t word = 0;     ///< the first that is replaced
  std::uint32_t words = 4;    ///< 1: a number, of coloured textures their luminance; 4: a colour, the fourth lane is 0
  TextureRole role = TextureRole::kReflectance;
};
static_assert(sizeof(TextureBinding) == 16);

/// What kernels see of a scene's textures.
struct TextureView {
  const TextureRow* rows = nullptr;
  const TexelTile* tiles = nullptr;            ///< with one tile of padding behind
  const AttributeEntry* attributes = nullptr;  ///< shape_count entries for each name that a texture reads
  const float* attribute_values = nullptr;     ///< one or three per vertex or face; three words of padding behind
  const std::uint32_t* triangles = nullptr;    ///< SceneView::triangles
  std::uint32_t shape_count = 0;
  const BrickGridRow* grids = nullptr;
};

/// Checkerboards, grids, mixes and wireframes of checkerboards of ...: no deeper than this, a board of constants
/// counted as 1.
inline constexpr int kMaxTextureDepth = 8;

/// The tables made from a description's textures.
struct CompiledTextures {
  std::vector<TextureRow> rows;  ///< one per description, in their order, followed by constants that those refer to
  std::unique_ptr<TexelTile[]> tiles;  ///< pictures one after the other and one tile of padding
  std::size_t tile_count = 0;          ///< with the padding
  /// Every name that a texture reads, once. Until AttributeTable::finish(), MeshAttributeRow::first_entry is an index
  /// of this list.
  std::vector<std::string> attribute_names;
  std::vector<BrickGrid> grids;
  std::vector<BrickGridRow> grid_rows;  ///< of each
  std::vector<std::string> warnings;
};

}  // namespace sheaf

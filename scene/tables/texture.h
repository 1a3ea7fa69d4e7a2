// Textures for kernels: rows, tiled texels and mesh attributes in flat tables. The files of scene/textures/ declare the
// data of each kind.
#pragma once

#include "core/soa/record_table.h"
#include "scene/tables/brick_grid.h"
#include "scene/tables/interpolation.h"
#include "scene/tables/table_bytes.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace sheaf {

/// The kind of a texture: its position in scene/textures/list.h, which names the values as
/// kTextureKind<BitmapDescription>.
enum class TextureKind : std::uint8_t {};

/// Bits of TextureRow::needs: what a lookup reads besides uv coordinates.
enum TextureNeeds : std::uint8_t {
  kTextureNeedsMesh = 1,   ///< values stored with the mesh, at a point of a triangle
  kTextureNeedsPoint = 2,  ///< the position in world space
};

/// Storage of a texel: one value, three bytes, or four halves or floats of which the fourth is 0. Byte 255 stands for 1
/// (kSrgbByte: sRGB-encoded, decoded before interpolation); halves (IEEE 754 binary16) and floats are linear.
enum class TexelFormat : std::uint8_t { kByte1, kByte3, kSrgbByte1, kSrgbByte3, kHalf1, kHalf4, kFloat1, kFloat4 };

constexpr bool holds_bytes(TexelFormat format) { return format <= TexelFormat::kSrgbByte3; }
constexpr bool holds_halves(TexelFormat format) {
  return format == TexelFormat::kHalf1 || format == TexelFormat::kHalf4;
}
/// Number of channels used: 1 or 3.
constexpr int texel_channels(TexelFormat format) { return static_cast<int>(format) % 2 == 0 ? 1 : 3; }

/// One cache line of texels. Images are divided into tiles of 8x8 (single bytes), 8x4 (single halves), 4x4 (three bytes
/// or one float), 4x2 (four halves) or 2x2 texels (four floats), row by row. Tiles are stored without gaps, row by row
/// from the image's lower left corner. The last tiles of rows and columns are padded. A tile takes one line, but those
/// of three bytes take three quarters of a line.
struct alignas(64) TexelLine {
  std::uint8_t bytes[64];
};

/// Bytes of a texel.
constexpr std::size_t bytes_per_texel(TexelFormat format) {
  const std::size_t value_bytes = holds_bytes(format) ? 1 : holds_halves(format) ? 2 : 4;
  return value_bytes * (texel_channels(format) == 1 ? 1 : holds_bytes(format) ? 3 : 4);
}

/// The size of tiles in texels: 2^x wide and 2^y high.
struct TileShift {
  int x, y;
  constexpr int texels() const { return x + y; }  ///< binary logarithm of the number of texels
  constexpr std::uint32_t columns(std::uint32_t width) const { return (width + (1u << x) - 1) >> x; }
  constexpr std::uint32_t rows(std::uint32_t height) const { return (height + (1u << y) - 1) >> y; }
};
constexpr TileShift tile_shift(TexelFormat format) {
  const int value_bits = holds_bytes(format) ? 0 : holds_halves(format) ? 1 : 2;
  const int texels = 6 - value_bits - (texel_channels(format) == 1 ? 0 : 2);
  return {(texels + 1) / 2, texels / 2};
}
/// Bytes of a tile.
constexpr std::size_t bytes_per_tile(TexelFormat format) {
  return bytes_per_texel(format) << tile_shift(format).texels();
}
/// Lines of this many tiles, and one of padding.
constexpr std::size_t padded_lines(TexelFormat format, std::size_t tiles) {
  return (tiles * bytes_per_tile(format) + sizeof(TexelLine) - 1) / sizeof(TexelLine) + 1;
}

/// Maximum number of texels of an image, including padding, so that 32-bit indices of words, or of the bytes of texels
/// of three bytes, address them.
inline constexpr std::size_t kMaxTexels = std::size_t{1} << 30;

/// A mip level of an image: the image at 1 / 2^level of its size, rounded down. Four words, loaded together.
template <class L> struct MipLevelRecord {
  typename L::Uint first_tile{};  ///< counted from TexelImage::mip_tiles
  typename L::Uint tiles_per_row{};
  typename L::Uint width{}, height{};  ///< texels, without padding
  static constexpr auto fields(auto& s) { return std::tie(s.first_tile, s.tiles_per_row, s.width, s.height); }
};
using MipLevel = MipLevelRecord<Scalar>;
static_assert(sizeof(MipLevel) == 16);

/// The first of the coarse mip levels, see MipLevels.
inline constexpr std::uint32_t kFirstCoarseLevel = 3;

/// Number of mip levels of an image besides the image itself. The last has one texel.
constexpr std::uint32_t mip_level_count(std::uint32_t width, std::uint32_t height) {
  return static_cast<std::uint32_t>(std::bit_width(std::max(width, height))) - 1;
}

/// Maximum number of textures that one texture combines.
inline constexpr std::uint32_t kMaxTextureInputs = 3;
/// Size of TextureRow::payload in bytes.
inline constexpr std::size_t kTexturePayloadBytes = 24;

/// One texture.
struct alignas(64) TextureRow {
  TextureKind kind{};                                       ///< 0: a constant
  std::uint8_t input_count = 0;                             ///< number of `inputs` in use
  std::uint8_t needs = 0;                                   ///< TextureNeeds of the texture and of its inputs
  float to_uv[6] = {1, 0, 0, 0, 1, 0};                      ///< TextureDescription::to_uv
  std::uint32_t inputs[kMaxTextureInputs] = {};             ///< textures that this one combines: into TextureView::rows
  alignas(4) std::byte payload[kTexturePayloadBytes] = {};  ///< see data()

  /// The data of the texture's kind, such as data<BitmapRow>().
  template <class Data> SHEAF_INLINE Data data() const {
    static_assert(sizeof(Data) <= kTexturePayloadBytes && std::is_trivially_copyable_v<Data>);
    Data data;
    std::memcpy(&data, payload, sizeof(data));
    return data;
  }
  template <class Data> void set_data(const Data& data) {
    static_assert(sizeof(Data) <= kTexturePayloadBytes && std::is_trivially_copyable_v<Data>);
    std::memcpy(payload, &data, sizeof(data));
  }
  std::span<const std::uint32_t> used_inputs() const { return {inputs, input_count}; }
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
  kReflectance,      ///< a color, clamped to [0, 1]
  kUnbounded,        ///< a color without bounds
  kBurleyLuminance,  ///< a scalar; for colors 0.3 red + 0.6 green + 0.1 blue
};

/// A texture that replaces some of a closure's parameter words.
struct TextureBinding {
  std::uint32_t texture = 0;  ///< into TextureView::rows
  std::uint32_t word = 0;     ///< first word that is replaced
  /// 1: a scalar, the luminance of colored textures; 4: a color with 0 in the fourth lane.
  std::uint32_t words = 4;
  TextureRole role = TextureRole::kReflectance;
};
static_assert(sizeof(TextureBinding) == 16);

struct TiledImage;
struct MipLevels;

/// The texels of an image and of its mip levels.
struct TexelImage {
  const TexelLine* tiles = nullptr;      ///< followed by one line of padding
  const MipLevel* mip_levels = nullptr;  ///< levels 1, 2 and so on; null: the image has none
  const TexelLine* mip_tiles = nullptr;  ///< followed by one line of padding
  MipLevels* levels = nullptr;           ///< owns them
};

/// Textures for kernels.
struct TextureView {
  const TextureRow* rows = nullptr;
  const TexelImage* images = nullptr;
  const AttributeEntry* attributes = nullptr;  ///< shape_count entries for each of TextureTables::attribute_names
  /// one or three values per vertex or face; followed by three words of padding
  const float* attribute_values = nullptr;
  const std::uint32_t* triangles = nullptr;  ///< GeometryView::triangles
  std::uint32_t shape_count = 0;
  const BrickGridRow* grids = nullptr;
  bool has_mip_levels = false;  ///< of any image
};

/// Maximum nesting depth of textures that combine others. A checkerboard of constants has depth 1.
inline constexpr int kMaxTextureDepth = 8;

/// Owns the textures of a scene.
struct TextureTables {
  /// One row per texture of the description, in order, followed by constants that these refer to.
  std::vector<TextureRow> rows;
  std::vector<TexelImage> images;  ///< images without mip levels, followed by those images again that have mip levels
  std::vector<std::shared_ptr<TiledImage>> tiled_images;  ///< what `images` point to, in the same order
  std::vector<std::string> attribute_names;               ///< mesh attributes in use, without duplicates
  /// Pairs of a row and the attribute that the meshes it is used on must have, an index into attribute_names.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> required_attributes;
  std::vector<AttributeEntry> attributes;
  std::vector<float> attribute_values;
  std::vector<BrickGrid> grids;
  std::vector<BrickGridRow> grid_rows;  ///< one per grid
  std::vector<std::string> warnings;

  /// `triangles`: GeometryView::triangles. `shape_count`: number of shapes.
  TextureView view(const std::uint32_t* triangles, std::uint32_t shape_count) const {
    return {rows.data(),       images.data(),
            attributes.data(), attribute_values.data(),
            triangles,         attributes.empty() ? 0u : shape_count,
            grid_rows.data(),  !images.empty() && images.back().mip_levels != nullptr};
  }
  /// Memory of the texels and mip levels in bytes.
  std::size_t texel_bytes() const;
  /// Memory in bytes.
  std::size_t bytes() const {
    std::size_t sum = bytes_of(rows, images, tiled_images, attributes, attribute_values) + texel_bytes();
    for (const BrickGrid& grid : grids) sum += grid.bytes();
    return sum;
  }
};

}  // namespace sheaf

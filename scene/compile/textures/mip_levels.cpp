#include "scene/compile/textures/mip_levels.h"

#include "core/color/color.h"
#include "core/math/half.h"
#include "core/soa/large_pages.h"
#include "scene/textures/lookups/bitmap.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cstring>
#include <map>
#include <utility>

namespace sheaf {

namespace {

/// Up to three neighboring texels along one axis, of which a texel of the next level is the weighted mean.
struct Taps {
  std::uint32_t first, count;
  float weight[3];
};

/// Covers [0, from) by `to` = max(from / 2, 1) texels of equal size.
std::vector<Taps> taps_of(std::uint32_t from, std::uint32_t to) {
  std::vector<Taps> taps(to);
  for (std::uint64_t x = 0; x < to; ++x) {
    // In units of 1 / to of a texel
    const std::uint64_t begin = x * from, end = begin + from, first = begin / to;
    Taps& out = taps[x];
    out = {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>((end + to - 1) / to - first), {}};
    for (std::uint32_t k = 0; k < out.count; ++k) {
      const std::uint64_t low = std::max(begin, (first + k) * to), high = std::min(end, (first + k + 1) * to);
      out.weight[k] = static_cast<float>(high - low) / static_cast<float>(from);
    }
  }
  return taps;
}

/// Decoding and encoding of bytes.
template <bool kSrgb> class ByteCurve {
 public:
  static const ByteCurve& get() {
    static const ByteCurve curve;
    return curve;
  }
  float decode(std::uint8_t byte) const { return values_[byte]; }
  /// The byte below or above, whose mean over `threshold` from 0 to 1 is the value. Exact for values of bytes.
  std::uint8_t encode(float value, float threshold) const {
    std::size_t byte = below_[static_cast<std::size_t>(value * kCells)];
    while (byte < 255 && values_[byte + 1] <= value) ++byte;
    if (byte < 255 && value - values_[byte] > threshold * (values_[byte + 1] - values_[byte])) ++byte;
    return static_cast<std::uint8_t>(byte);
  }

 private:
  static constexpr int kCells = 1 << 12;

  ByteCurve() {
    for (std::size_t i = 0; i < 256; ++i) {
      const float encoded = static_cast<float>(i) / 255.0f;
      values_[i] = kSrgb ? srgb_to_linear(encoded) : encoded;
    }
    std::size_t byte = 0;
    for (std::size_t cell = 0; cell <= kCells; ++cell) {
      while (byte < 255 && values_[byte + 1] <= static_cast<float>(cell) / kCells) ++byte;
      below_[cell] = static_cast<std::uint8_t>(byte);
    }
  }

  std::array<float, 256> values_;
  std::array<std::uint8_t, kCells + 1> below_;  ///< the largest byte with at most the value cell / kCells
};

/// A number in [0, 1) from the position of a texel.
float threshold_at(std::uint32_t x, std::uint32_t y) {
  std::uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  return static_cast<float>((h ^ h >> 13) >> 8) * 0x1p-24f;
}

/// The texels of an image or level.
template <TexelFormat kFormat> struct Texels {
  static constexpr int kChannels = texel_channels(kFormat), kStored = kChannels == 1 ? 1 : 4;
  using Value = std::conditional_t<holds_bytes(kFormat), std::uint8_t,
                                   std::conditional_t<holds_halves(kFormat), std::uint16_t, float>>;
  using Curve = ByteCurve<kFormat == TexelFormat::kSrgbByte1 || kFormat == TexelFormat::kSrgbByte4>;

  TexelTile* tiles;
  std::uint32_t width, height, tiles_per_row;

  /// The channels of a texel. `row`: row_index().
  Value* at(std::size_t row, std::uint32_t x) const {
    return reinterpret_cast<Value*>(tiles) + (row + bitmap_detail::column_index<kFormat>(x)) * kStored;
  }
  std::size_t row(std::uint32_t y) const {
    return bitmap_detail::row_index<kFormat>(std::size_t{y}, std::size_t{tiles_per_row});
  }
};

/// The linear value of a channel, and its storage.
template <TexelFormat kFormat> float decode(typename Texels<kFormat>::Value value) {
  if constexpr (holds_bytes(kFormat))
    return Texels<kFormat>::Curve::get().decode(value);
  else if constexpr (holds_halves(kFormat))
    return half_to_float(value);
  else
    return value;
}
template <TexelFormat kFormat> auto encode(float value, [[maybe_unused]] float threshold) {
  if constexpr (holds_bytes(kFormat))
    return Texels<kFormat>::Curve::get().encode(std::min(value, 1.0f), threshold);
  else if constexpr (holds_halves(kFormat))
    return float_to_half(value);
  else
    return value;
}

/// Computes row `y` of a level from the previous one. `kEven`: each texel is the mean of two by two.
template <TexelFormat kFormat, bool kEven>
void fill_row(const Texels<kFormat>& from, const Texels<kFormat>& to, const std::vector<Taps>& columns,
              const Taps& rows, std::uint32_t y) {
  using T = Texels<kFormat>;
  const std::size_t row = to.row(y);
  std::size_t source_rows[3] = {};
  for (std::uint32_t j = 0; j < rows.count; ++j) source_rows[j] = from.row(rows.first + j);
  for (std::uint32_t x = 0; x < to.width; ++x) {
    float sum[T::kChannels] = {};
    if constexpr (kEven) {
      // Neighbors in a row lie in one tile
      const auto *below = from.at(source_rows[0], 2 * x), *above = from.at(source_rows[1], 2 * x);
      for (int c = 0; c < T::kChannels; ++c)
        sum[c] = 0.25f * (decode<kFormat>(below[c]) + decode<kFormat>(below[c + T::kStored]) +
                          decode<kFormat>(above[c]) + decode<kFormat>(above[c + T::kStored]));
    } else {
      const Taps& taps = columns[x];
      for (std::uint32_t j = 0; j < rows.count; ++j)
        for (std::uint32_t i = 0; i < taps.count; ++i) {
          const auto* value = from.at(source_rows[j], taps.first + i);
          for (int c = 0; c < T::kChannels; ++c) sum[c] += rows.weight[j] * taps.weight[i] * decode<kFormat>(value[c]);
        }
    }
    auto* out = to.at(row, x);
    const float threshold = threshold_at(x, y);
    for (int c = 0; c < T::kChannels; ++c) out[c] = encode<kFormat>(sum[c], threshold);
    for (int c = T::kChannels; c < T::kStored; ++c) out[c] = 0;
  }
}

template <TexelFormat kFormat> void fill_level(const Texels<kFormat>& from, const Texels<kFormat>& to) {
  const std::vector<Taps> columns = taps_of(from.width, to.width), rows = taps_of(from.height, to.height);
  const bool even = from.width == 2 * to.width && from.height == 2 * to.height;
  // Rows of tiles, which share cache lines
  constexpr std::uint32_t kRows = 1u << tile_shift(kFormat).y;
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, (to.height + kRows - 1) / kRows), [&](const auto& range) {
    const std::uint32_t end = std::min(range.end() * kRows, to.height);
    for (std::uint32_t y = range.begin() * kRows; y < end; ++y) {
      if (even)
        fill_row<kFormat, true>(from, to, columns, rows[y], y);
      else
        fill_row<kFormat, false>(from, to, columns, rows[y], y);
    }
  });
}

/// Adds to `found` the rows of a texture and of those that it combines.
void add_textures(const TextureTables& textures, std::uint32_t row, std::vector<bool>& found) {
  if (found[row]) return;
  found[row] = true;
  for (const std::uint32_t input : textures.rows[row].used_inputs()) add_textures(textures, input, found);
}

/// Rows of bilinear images that are used as reflectances only.
std::vector<std::uint32_t> reflectance_images(const MaterialTables& materials, const TextureTables& textures) {
  std::vector<bool> colors(textures.rows.size()), others(textures.rows.size());
  for (const TextureBinding& binding : materials.bindings) {
    const bool is_color = binding.role == TextureRole::kReflectance && binding.words == 4;
    // Scalar lookups ignore mip levels
    if (is_color || binding.words == 4 || binding.role == TextureRole::kBurleyLuminance)
      add_textures(textures, binding.texture, is_color ? colors : others);
  }
  for (const NormalMapRow& map : materials.normal_maps) add_textures(textures, map.texture, others);
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < textures.rows.size(); ++i) {
    const TextureRow& row = textures.rows[i];
    if (!colors[i] || others[i] || row.kind != kTextureKind<BitmapDescription>) continue;
    const auto bitmap = row.data<BitmapRow>();
    if (bitmap.filter == TextureFilter::kBilinear && std::max(bitmap.width, bitmap.height) > 1) rows.push_back(i);
  }
  return rows;
}

/// Appends the levels of an image to the table. Returns the number of their tiles.
std::size_t place_levels(const BitmapRow& bitmap, std::size_t first_tile, std::vector<MipLevel>& levels) {
  const TileShift shift = tile_shift(bitmap.format);
  std::size_t tile = first_tile;
  for (std::uint32_t l = 1; l <= mip_level_count(bitmap.width, bitmap.height); ++l) {
    const std::uint32_t width = std::max(bitmap.width >> l, 1u), height = std::max(bitmap.height >> l, 1u);
    const MipLevel level{static_cast<std::uint32_t>(tile), shift.columns(width), width, height};
    levels.push_back(level);
    tile += std::size_t{level.tiles_per_row} * shift.rows(height);
  }
  return tile - first_tile;
}

/// The texels of TextureTables and of their mip levels, which do not move with the tables.
struct TexelMemory {
  TexelTile *tiles, *mip_tiles;
  const MipLevel* levels;
};

void fill_levels(const BitmapRow& bitmap, const TexelMemory& memory) {
  bitmap_detail::with_format(bitmap.format, [&]<TexelFormat kFormat>() {
    Texels<kFormat> from{&memory.tiles[bitmap.first_tile], bitmap.width, bitmap.height, bitmap.tiles_per_row};
    for (std::uint32_t l = 0; l < mip_level_count(bitmap.width, bitmap.height); ++l) {
      const MipLevel& level = memory.levels[bitmap.first_level + l];
      const Texels<kFormat> to{&memory.mip_tiles[level.first_tile], level.width, level.height, level.tiles_per_row};
      fill_level(from, to);
      from = to;
    }
  });
}

}  // namespace

std::function<void()> add_mip_levels(const MaterialTables& materials, TextureTables& textures) {
  // Textures that read the same texels in the same way share their levels
  std::map<std::pair<std::uint32_t, TexelFormat>, BitmapRow> images;
  std::size_t tiles = 0;
  for (const std::uint32_t i : reflectance_images(materials, textures)) {
    auto bitmap = textures.rows[i].data<BitmapRow>();
    const auto [known, is_new] = images.try_emplace({bitmap.first_tile, bitmap.format}, bitmap);
    if (is_new) {
      known->second.first_level = static_cast<std::uint32_t>(textures.mip_levels.size());
      tiles += place_levels(bitmap, tiles, textures.mip_levels);
    }
    bitmap.first_level = known->second.first_level;
    textures.rows[i].set_data(bitmap);
  }
  if (images.empty()) return [] {};
  textures.mip_tile_count = tiles + 1;
  textures.mip_tiles = std::make_unique_for_overwrite<TexelTile[]>(textures.mip_tile_count);
  prefer_large_pages(textures.mip_tiles.get(), textures.mip_tile_count * sizeof(TexelTile));
  textures.mip_tiles[tiles] = {};
  return [images = std::move(images),
          memory = TexelMemory{textures.tiles.get(), textures.mip_tiles.get(), textures.mip_levels.data()}] {
    for (const auto& [key, bitmap] : images) fill_levels(bitmap, memory);
  };
}

}  // namespace sheaf

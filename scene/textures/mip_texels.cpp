#include "scene/textures/mip_texels.h"

#include "core/color/color.h"
#include "core/math/half.h"
#include "scene/textures/lookups/bitmap.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

namespace sheaf {

namespace {

/// The size of the image over that of the first coarse level.
constexpr std::uint32_t kCoarseFactor = 1u << kFirstCoarseLevel;
/// Maximum number of texels that a texel of a coarser level covers or touches along one axis.
constexpr std::uint32_t kMaxTaps = 2 * kCoarseFactor + 1;

/// Neighboring texels along one axis, of which a texel of a coarser level is the weighted mean.
struct Taps {
  std::uint32_t first, count;
  float weight[kMaxTaps];
};

/// Covers [0, from) by `to` texels of equal size, at least from / (2 kCoarseFactor).
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

/// The byte below or above a value in [0, 1], whose mean over `threshold` from 0 to 1 is the value. Exact for values of
/// bytes.
template <class L, TexelFormat kFormat> Uint<L> encode_byte(Float<L> value, Float<L> threshold) {
  using F = Float<L>;
  using U = Uint<L>;
  using bitmap_detail::decode_byte;
  F near = value * F(255.0f);
  if constexpr (kFormat == TexelFormat::kSrgbByte1 || kFormat == TexelFormat::kSrgbByte3) {
    // A polynomial of the square root with a maximum error of 0.2 fits the curve above its linear part
    const F root = sqrt(value);
    F curve(-78.939452f);
    for (const float c : {214.908964f, -240.937741f, 369.21393f, -9.43616747f}) curve = fma(curve, root, F(c));
    near = select(value < F(0.0031308f), value * F(255.0f * 12.92f), curve);
  }
  // The byte below, or the one before it
  const U byte = to_uint(max(near - F(0.25f), F(0.0f)));
  const F first = decode_byte<kFormat>(byte), second = decode_byte<kFormat>(byte + U(1u)),
          third = decode_byte<kFormat>(byte + U(2u));
  const auto is_first = value < second;
  const F low = select(is_first, first, second), high = select(is_first, second, third);
  const U below = select(is_first, byte, byte + U(1u));
  return select(value - low > threshold * (high - low), below + U(1u), below);
}

/// A number in [0, 1) from the position of a texel.
template <class L> Float<L> threshold_at(Uint<L> x, std::uint32_t y) {
  using U = Uint<L>;
  U h = (x * U(0x9e3779b1u)) ^ U(y * 0x85ebca77u);
  h = (h ^ (h >> 15)) * U(0x2c1b3c6du);
  return to_float((h ^ (h >> 13)) >> 8) * Float<L>(0x1p-24f);
}

/// The texels of an image or level.
template <TexelFormat kFormat> struct Texels {
  static constexpr int kChannels = texel_channels(kFormat);
  using Value = std::conditional_t<holds_bytes(kFormat), std::uint8_t,
                                   std::conditional_t<holds_halves(kFormat), std::uint16_t, float>>;
  static constexpr int kStored = static_cast<int>(bytes_per_texel(kFormat) / sizeof(Value));

  std::uint8_t* bytes;
  std::uint32_t width, height, tiles_per_row;

  /// The channels of a texel. `row`: row().
  Value* at(std::uint32_t row, std::uint32_t x) const {
    return reinterpret_cast<Value*>(bytes) + std::size_t{row + bitmap_detail::column_index<kFormat>(x)} * kStored;
  }
  /// The contribution of a row to the indices of its texels.
  std::uint32_t row(std::uint32_t y) const { return bitmap_detail::row_index<kFormat>(y, tiles_per_row); }
};

/// Row `y` of a level, and the rows of a finer one that it covers.
template <TexelFormat kFormat> struct LevelRow {
  Texels<kFormat> from, to;
  std::uint32_t y;
  const Taps& taps;
  std::uint32_t row, source_rows[kMaxTaps];

  LevelRow(const Texels<kFormat>& finer, const Texels<kFormat>& level, const Taps& rows, std::uint32_t index)
      : from(finer), to(level), y(index), taps(rows), row(level.row(index)), source_rows{} {
    for (std::uint32_t j = 0; j < rows.count; ++j) source_rows[j] = finer.row(rows.first + j);
  }
};

/// Adds linear texels, weighted, to `sum`.
template <class L, TexelFormat kFormat>
void add_texels(const Texels<kFormat>& from, Uint<L> index, Float<L> weight, Float<L>* sum) {
  const auto texel = bitmap_detail::StoredTexel<L, kFormat>::load(from.bytes, index);
  bitmap_detail::for_each_channel<kFormat>([&]<int K>() { sum[K] = fma(weight, texel.template channel<K>(), sum[K]); });
}

/// Stores one texel per lane from column x on.
template <class L, TexelFormat kFormat>
void store_texels(const LevelRow<kFormat>& row, std::uint32_t x, Uint<L> columns, const Float<L>* values) {
  using T = Texels<kFormat>;
  constexpr int kLanes = LaneArray<Float<L>>::kLanes;
  if constexpr (holds_bytes(kFormat)) {
    const Float<L> threshold = threshold_at<L>(columns, row.y);
    Uint<L> packed(0u);
    for (int c = 0; c < T::kChannels; ++c)
      packed = packed | (encode_byte<L, kFormat>(min(values[c], Float<L>(1.0f)), threshold) << (8 * c));
    const LaneArray<Uint<L>> words(packed);
    for (int k = 0; k < kLanes; ++k) {
      const std::uint32_t word = words[k];
      std::memcpy(row.to.at(row.row, x + static_cast<std::uint32_t>(k)), &word, T::kStored);
    }
  } else {
    for (int c = 0; c < T::kStored; ++c) {
      const LaneArray<Float<L>> channel(c < T::kChannels ? values[c] : Float<L>(0.0f));
      for (int k = 0; k < kLanes; ++k) {
        auto& out = row.to.at(row.row, x + static_cast<std::uint32_t>(k))[c];
        if constexpr (holds_halves(kFormat))
          out = float_to_half(channel[k]);
        else
          out = channel[k];
      }
    }
  }
}

/// Computes texels from column x on, one per lane, as means of kFactor by kFactor.
template <std::uint32_t kFactor, class L, TexelFormat kFormat>
void average_squares(const LevelRow<kFormat>& row, std::uint32_t x) {
  using U = Uint<L>;
  const U columns = U(x) + L::index();
  const Float<L> weight(1.0f / (kFactor * kFactor));
  Float<L> sum[3] = {Float<L>(0.0f), Float<L>(0.0f), Float<L>(0.0f)};
  for (std::uint32_t j = 0; j < kFactor; ++j)
    for (std::uint32_t i = 0; i < kFactor; ++i) {
      const U column = bitmap_detail::column_index<kFormat>(columns * U(kFactor) + U(i));
      add_texels<L, kFormat>(row.from, U(row.source_rows[j]) + column, weight, sum);
    }
  store_texels<L, kFormat>(row, x, columns, sum);
}

/// Computes the texel in column x from those that it covers.
template <TexelFormat kFormat>
void average_covered(const LevelRow<kFormat>& row, const Taps& columns, std::uint32_t x) {
  float sum[3] = {};
  for (std::uint32_t j = 0; j < row.taps.count; ++j)
    for (std::uint32_t i = 0; i < columns.count; ++i) {
      const std::uint32_t index = row.source_rows[j] + bitmap_detail::column_index<kFormat>(columns.first + i);
      add_texels<Scalar, kFormat>(row.from, index, row.taps.weight[j] * columns.weight[i], sum);
    }
  store_texels<Scalar, kFormat>(row, x, x, sum);
}

/// Computes a level of 1 / kFactor of the size of `from`.
template <std::uint32_t kFactor, TexelFormat kFormat>
void fill_level(const Texels<kFormat>& from, const Texels<kFormat>& to) {
  const std::vector<Taps> columns = taps_of(from.width, to.width), rows = taps_of(from.height, to.height);
  const bool divides = from.width == kFactor * to.width && from.height == kFactor * to.height;
  // Rows of tiles, which share cache lines
  constexpr std::uint32_t kRows = 1u << tile_shift(kFormat).y;
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, (to.height + kRows - 1) / kRows), [&](const auto& range) {
    const std::uint32_t end = std::min(range.end() * kRows, to.height);
    for (std::uint32_t y = range.begin() * kRows; y < end; ++y) {
      const LevelRow<kFormat> row(from, to, rows[y], y);
      std::uint32_t x = 0;
      for (; divides && x + kWidth <= to.width; x += kWidth) average_squares<kFactor, Wide>(row, x);
      for (; x < to.width; ++x) average_covered(row, columns[x], x);
    }
  });
}

/// Computes levels first to last, the first of them from the image at 1 / kFactor of its size.
template <std::uint32_t kFactor> void fill_levels(MipLevels& out, std::uint32_t first, std::uint32_t last) {
  const TiledImage& image = *out.image;
  bitmap_detail::with_format(out.format, [&]<TexelFormat kFormat>() {
    const auto texels_of = [&](std::uint32_t level) {
      const MipLevel& extent = out.levels[level - 1];
      std::uint8_t* const bytes = out.tiles[0].bytes + extent.first_tile * bytes_per_tile(kFormat);
      return Texels<kFormat>{bytes, extent.width, extent.height, extent.tiles_per_row};
    };
    // The image is only read
    const Texels<kFormat> base{const_cast<std::uint8_t*>(image.tiles[0].bytes), image.width, image.height,
                               image.tiles_per_row};
    if (first <= last) fill_level<kFactor>(base, texels_of(first));
    for (std::uint32_t level = first + 1; level <= last; ++level) fill_level<2>(texels_of(level - 1), texels_of(level));
  });
}

std::uint32_t level_count(const MipLevels& levels) { return static_cast<std::uint32_t>(levels.levels.size()); }

}  // namespace

std::shared_ptr<MipLevels> place_levels(const TiledImage& image, TexelFormat format) {
  const TileShift shift = tile_shift(image.format);
  auto out = std::make_shared<MipLevels>();
  out->image = &image;
  out->format = format;
  std::size_t tile = 0;
  for (std::uint32_t l = 1; l <= mip_level_count(image.width, image.height); ++l) {
    const std::uint32_t width = std::max(image.width >> l, 1u), height = std::max(image.height >> l, 1u);
    out->levels.push_back({static_cast<std::uint32_t>(tile), shift.columns(width), width, height});
    tile += std::size_t{shift.columns(width)} * shift.rows(height);
  }
  const std::size_t lines = padded_lines(image.format, tile);
  out->tiles.resize(lines);
  out->tiles[lines - 2] = out->tiles[lines - 1] = {};  // tiles may end within a line
  return out;
}

void fill_coarse_levels(MipLevels& levels) {
  std::call_once(levels.coarse_once,
                 [&] { fill_levels<kCoarseFactor>(levels, kFirstCoarseLevel, level_count(levels)); });
}

void fill_fine_levels(MipLevels& levels) {
  // A thread that waits for its loop must not start other work, which could need the same levels
  const auto fill = [&] {
    tbb::this_task_arena::isolate(
        [&] { fill_levels<2>(levels, 1, std::min(kFirstCoarseLevel - 1, level_count(levels))); });
    levels.has_fine.store(true, std::memory_order_release);
  };
  std::call_once(levels.fine_once, fill);
}

}  // namespace sheaf

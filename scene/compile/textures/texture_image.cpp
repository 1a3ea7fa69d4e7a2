// Converts an image, with rows from the top, to tiles of texels, with rows from the bottom.
#include "scene/compile/textures/texture_image.h"

#include "core/color/srgb_bytes.h"
#include "core/image/exr.h"
#include "core/image/exr_halves.h"
#include "core/image/image.h"
#include "core/image/image_channels.h"
#include "core/image/image_rows.h"
#include "core/io/file_cache.h"
#include "core/io/memory.h"
#include "core/io/parallel_ranges.h"
#include "core/math/half.h"
#include "core/soa/large_pages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <type_traits>

namespace sheaf {

namespace {

/// The values of an image from which texels are made: `channels` of each pixel of `stride` values.
template <class T> struct PixelValues {
  std::span<T> values;  ///< rows from the top
  std::size_t stride;
  const std::vector<std::size_t>& channels;
};

/// Stores a row of texels, converted by `convert`, in a row of tiles that begins at `tiles`. `channel_at(k)`: the k-th
/// selected channel; a function, because constants make the loop fast.
template <int kChannels, class T, class Channel, class Convert>
void store_pixels(T* pixels, std::size_t stride, std::size_t width, TileShift shift, std::uint8_t* tiles,
                  std::size_t row_of_tile, Channel&& channel_at, Convert&& convert) {
  using Texel = std::decay_t<decltype(convert(*pixels))>;
  constexpr std::size_t kValues = kChannels == 1 ? 1 : sizeof(Texel) == 1 ? 3 : 4, kBytes = kValues * sizeof(Texel);
  const std::size_t columns = std::size_t{1} << shift.x, row_bytes = columns * kBytes, tile = row_bytes << shift.y;
  for (std::size_t x = 0; x < width; x += columns) {
    std::uint8_t* out = tiles + (x >> shift.x) * tile + row_of_tile * row_bytes;
    const std::size_t end = std::min(x + columns, width);
    for (std::size_t at = x; at < end; ++at, out += kBytes) {
      Texel texel[kValues] = {};
      for (int k = 0; k < kChannels; ++k) texel[k] = convert(pixels[at * stride + channel_at(k)]);
      std::memcpy(out, texel, kBytes);
    }
  }
}

/// Stores a row of texels.
template <class T, class Convert>
void store_row(const PixelValues<T>& from, T* pixels, std::size_t width, TileShift shift, std::uint8_t* tiles,
               std::size_t row_of_tile, Convert&& convert) {
  const auto& channels = from.channels;
  const auto in_order = [](int k) { return static_cast<std::size_t>(k); };
  const auto any_order = [&](int k) { return channels[static_cast<std::size_t>(k)]; };
  const bool is_rgb = channels.size() == 3 && channels[0] == 0 && channels[1] == 1 && channels[2] == 2;
  const auto store = [&]<int kChannels>(std::size_t stride, auto&& channel_at) {
    store_pixels<kChannels>(pixels, stride, width, shift, tiles, row_of_tile, channel_at, convert);
  };
  if (channels.size() == 1)
    store.template operator()<1>(from.stride, any_order);
  else if (is_rgb && from.stride == 3)
    store.template operator()<3>(3, in_order);
  else if (is_rgb && from.stride == 4)
    store.template operator()<3>(4, in_order);
  else
    store.template operator()<3>(from.stride, any_order);
}

/// The number of rows of tiles that take about `bytes`, at least one.
std::size_t tile_rows_of(const TiledImage& image, std::size_t bytes) {
  return std::max<std::size_t>(bytes / (image.tiles_per_row * bytes_per_tile(image.format)), 1);
}
constexpr std::size_t kRangeBytes = std::size_t{1} << 20;  // of one thread

/// A band of rows of an image: rows of tiles [begin, end), or rows of texels [bottom, top), from the bottom.
struct Band {
  std::size_t begin, end, bottom, top;

  Band(const TiledImage& image, std::size_t first, std::size_t last)
      : begin(first),
        end(last),
        bottom(first << tile_shift(image.format).y),
        top(std::min<std::size_t>(last << tile_shift(image.format).y, image.height)) {}
};

/// Makes the texels of a band from its values, by all threads.
template <class T, class Convert>
void fill_band(TiledImage& image, const Band& band, const PixelValues<T>& from, Convert&& convert) {
  const TileShift shift = tile_shift(image.format);
  const std::size_t row_bytes = image.tiles_per_row * bytes_per_tile(image.format);
  std::uint8_t* const bytes = image.tiles[0].bytes;
  const auto fill = [&](std::size_t first, std::size_t last) {
    const Band part(image, band.begin + first, band.begin + last);
    std::memset(bytes + part.begin * row_bytes, 0, (part.end - part.begin) * row_bytes);
    for (std::size_t y = part.bottom; y < part.top; ++y)
      store_row(from, &from.values[(band.top - 1 - y) * image.width * from.stride], image.width, shift,
                bytes + (y >> shift.y) * row_bytes, y & ((std::size_t{1} << shift.y) - 1), convert);
  };
  parallel_ranges(band.end - band.begin, fill, tile_rows_of(image, kRangeBytes));
}

/// Makes the texels of an image. Releases values, unless they are const, after every band, so that most of the image
/// exists only once.
template <class T, class Convert> void fill_tiles(TiledImage& image, const PixelValues<T>& from, Convert&& convert) {
  constexpr std::size_t kBandBytes = std::size_t{64} << 20, kReleased = std::size_t{4} << 20;
  const std::size_t tile_rows = tile_shift(image.format).rows(image.height), step = tile_rows_of(image, kBandBytes),
                    row_values = image.width * from.stride;
  for (std::size_t begin = 0; begin < tile_rows; begin += step) {
    const Band band(image, begin, std::min(begin + step, tile_rows));
    const std::span<T> values =
        from.values.subspan((image.height - band.top) * row_values, (band.top - band.bottom) * row_values);
    fill_band(image, band, PixelValues<T>{values, from.stride, from.channels}, convert);
    if constexpr (!std::is_const_v<T>) {
      if (values.size_bytes() >= kReleased) release_pages(values.data(), values.size_bytes());
    }
  }
}

/// Throws SceneError if a value of the selected channels is not finite. `value_at(i)`: the i-th value of the image.
template <class ValueAt>
void check_finite(int width, int height, const std::vector<std::string>& names,
                  const std::vector<std::size_t>& channels, const SourceLocation& where, ValueAt&& value_at) {
  const std::size_t columns = static_cast<std::size_t>(width), pixels = columns * static_cast<std::size_t>(height);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    for (const std::size_t c : channels)
      if (!std::isfinite(value_at(pixel * names.size() + c))) {
        throw SceneError(
            where,
            fmt::format("channel {} of the pixel in column {}, row {} (from the upper left) is not a finite number",
                        names[c], pixel % columns, pixel / columns));
      }
}

/// Whether all values of the selected channels are exact as halves.
bool are_halves(std::span<const float> values, std::size_t stride, const std::vector<std::size_t>& channels) {
  for (std::size_t pixel = 0; pixel < values.size(); pixel += stride)
    for (const std::size_t c : channels)
      if (half_to_float(float_to_half(values[pixel + c])) != values[pixel + c]) return false;
  return true;
}

/// Decodes the selected channels.
void decode_floats(StoredImage& stored, const std::vector<std::size_t>& channels) {
  for (std::size_t pixel = 0; pixel < stored.floats.size(); pixel += stored.channels.size())
    for (const std::size_t c : channels) stored.floats[pixel + c] = srgb_to_linear(stored.floats[pixel + c]);
}

/// The format of texels with one channel if `gray`.
TexelFormat format_of(bool bytes, bool halves, bool gray) {
  if (bytes) return gray ? TexelFormat::kByte1 : TexelFormat::kByte3;
  if (halves) return gray ? TexelFormat::kHalf1 : TexelFormat::kHalf4;
  return gray ? TexelFormat::kFloat1 : TexelFormat::kFloat4;
}

/// Converts all values to floats, decoded unless `linear`, and applies the color transform.
void change_values(StoredImage& stored, bool linear, const BitmapDescription::ColorTransform& change) {
  bool decode = !linear && (stored.integers || !stored.bytes.empty());
  if (stored.floats.empty()) {
    stored.floats.resize(stored.bytes.size());
    std::transform(stored.bytes.begin(), stored.bytes.end(), stored.floats.begin(), [&](std::uint8_t byte) {
      return decode ? linear_of_srgb_bytes()[byte] : static_cast<float>(byte) / 255.0f;
    });
    decode = false;
  }
  stored.bytes = {};
  stored.integers = false;
  for (float& value : stored.floats) {
    value = (decode ? srgb_to_linear(value) : value) * change.scale;
    if (change.invert) value = 1 - value;
    if (change.exponent != 1.0f)
      value = std::pow(std::max(value, 0.0f), change.exponent);
    else if (change.invert)
      value = std::max(value, 0.0f);
  }
}

/// One opaque pixel: the alpha of an image without alpha.
StoredImage opaque_pixel() {
  StoredImage pixel;
  pixel.width = pixel.height = 1;
  pixel.channels = {"A"};
  pixel.bytes = {255};
  pixel.integers = true;
  return pixel;
}

/// Indices of the channels that the texture uses: one or three, or none if that is the alpha of an image without alpha.
std::vector<std::size_t> select_channels(const std::vector<std::string>& names, BitmapDescription::Channel channel,
                                         const SourceLocation& where) {
  using Channel = BitmapDescription::Channel;
  const ColorChannels found = find_color_channels(names, where);
  if (channel == Channel::kColor) return found.channels;
  if (channel != Channel::kAlpha) {
    const auto index = static_cast<std::size_t>(channel) - static_cast<std::size_t>(Channel::kRed);
    return {found.channels[std::min(index, found.channels.size() - 1)]};
  }
  if (found.alpha) return {*found.alpha};
  return {};
}

/// An image of this size with space for its tiles. Throws SceneError if it is too large.
TiledImage prepare_tiles(int width, int height, TexelFormat format, const SourceLocation& where) {
  TiledImage image;
  image.width = static_cast<std::uint32_t>(width);
  image.height = static_cast<std::uint32_t>(height);
  image.format = format;
  const TileShift shift = tile_shift(image.format);
  image.tiles_per_row = shift.columns(image.width);
  const std::size_t tiles = std::size_t{image.tiles_per_row} * shift.rows(image.height);
  if (tiles << shift.texels() > kMaxTexels) {
    throw SceneError(
        where, fmt::format("an image of {} x {} pixels is too large for a texture (expected at most {} texels)", width,
                           height, kMaxTexels));
  }
  const std::size_t lines = padded_lines(format, tiles);
  const MemoryUse texels{"its texels", static_cast<double>(lines) * sizeof(TexelLine), "use a smaller image"};
  check_memory(fmt::format("{} of {} x {} pixels",
                           where.file.empty() ? "a texture" : fmt::format("the texture '{}'", where.file.string()),
                           width, height),
               {&texels, 1});
  image.tiles.resize(lines);
  image.tiles[lines - 2] = image.tiles[lines - 1] = {};  // tiles may end within a line
  return image;
}

/// The pixels of an image in memory, as if read from a file.
StoredImage stored_image(const Image& made) {
  StoredImage stored;
  stored.width = made.width;
  stored.height = made.height;
  stored.channels = made.channels;
  stored.floats = made.data;
  return stored;
}

/// The texture of decoded `values`, bytes or floats.
template <class T>
TiledImage tile_values(std::span<T> values, int width, int height, std::size_t stride,
                       const std::vector<std::size_t>& channels, const SourceLocation& where) {
  constexpr bool kBytes = sizeof(T) == 1;
  bool halves = false;
  if constexpr (!kBytes) halves = are_halves(values, stride, channels);
  TiledImage image = prepare_tiles(width, height, format_of(kBytes, halves, channels.size() == 1), where);
  if constexpr (!kBytes) {
    if (halves) {
      fill_tiles(image, PixelValues<T>{values, stride, channels}, float_to_half);
      return image;
    }
  }
  fill_tiles(image, PixelValues<T>{values, stride, channels}, std::identity{});
  return image;
}

TiledImage tile_stored_image(StoredImage stored, const BitmapDescription& bitmap, const SourceLocation& where) {
  std::vector<std::size_t> channels = select_channels(stored.channels, bitmap.channel, where);
  if (channels.empty()) {
    stored = opaque_pixel();
    channels = {0};
  }
  if (bitmap.change != BitmapDescription::ColorTransform{}) change_values(stored, bitmap.is_linear(), bitmap.change);
  if (stored.bytes.empty())
    check_finite(stored.width, stored.height, stored.channels, channels, where,
                 [&](std::size_t i) { return stored.floats[i]; });
  if (stored.bytes.empty() && stored.integers && !bitmap.is_linear()) decode_floats(stored, channels);
  return stored.bytes.empty() ? tile_values(std::span(stored.floats), stored.width, stored.height,
                                            stored.channels.size(), channels, where)
                              : tile_values(std::span(stored.bytes), stored.width, stored.height,
                                            stored.channels.size(), channels, where);
}

/// The texture of an image in memory.
TiledImage tile_made(const Image& made, const BitmapDescription& bitmap, const SourceLocation& where) {
  const std::vector<std::size_t> channels = select_channels(made.channels, bitmap.channel, where);
  if (channels.empty()) return tile_stored_image(opaque_pixel(), bitmap, where);
  if (bitmap.change != BitmapDescription::ColorTransform{}) return tile_stored_image(stored_image(made), bitmap, where);
  check_finite(made.width, made.height, made.channels, channels, where, [&](std::size_t i) { return made.data[i]; });
  return tile_values(std::span(made.data), made.width, made.height, made.channels.size(), channels, where);
}

/// The texture of an OpenEXR file of halves. Returns nothing for other files, and if values change.
std::optional<TiledImage> tile_halves(const BitmapDescription& bitmap, const SourceLocation& where) {
  std::error_code ignored;
  if (bitmap.change != BitmapDescription::ColorTransform{} || !std::filesystem::is_regular_file(bitmap.file, ignored) ||
      !is_exr(bitmap.file))
    return std::nullopt;
  std::optional<HalfImage> halves = read_exr_halves(bitmap.file, bitmap.raw);
  if (!halves) return std::nullopt;
  const std::vector<std::size_t> channels = select_channels(halves->channels, bitmap.channel, where);
  if (channels.empty()) return std::nullopt;
  check_finite(halves->width, halves->height, halves->channels, channels, where,
               [&](std::size_t i) { return half_to_float(halves->values[i]); });
  TiledImage image = prepare_tiles(halves->width, halves->height, format_of(false, true, channels.size() == 1), where);
  fill_tiles(image, PixelValues<std::uint16_t>{halves->values, halves->channels.size(), channels}, std::identity{});
  return image;
}

/// The texture of a file of bytes that is read in bands of rows from the top. Returns nothing for other files, and if
/// values change.
std::optional<TiledImage> tile_rows(const BitmapDescription& bitmap, const SourceLocation& where) {
  if (bitmap.change != BitmapDescription::ColorTransform{}) return std::nullopt;
  std::optional<ImageRows> rows = ImageRows::open(bitmap.file);
  if (!rows) return std::nullopt;
  const ImageHeader& header = rows->header();
  const std::vector<std::size_t> channels = select_channels(header.channels, bitmap.channel, where);
  if (channels.empty()) return std::nullopt;
  TiledImage image = prepare_tiles(header.width, header.height, format_of(true, false, channels.size() == 1), where);
  const std::size_t step = tile_rows_of(image, kRangeBytes), stride = header.channels.size();
  std::vector<std::uint8_t> values;
  for (std::size_t end = tile_shift(image.format).rows(image.height); end > 0; end -= std::min(step, end)) {
    const Band band(image, end - std::min(step, end), end);
    values.resize((band.top - band.bottom) * image.width * stride);
    rows->read(static_cast<int>(band.top - band.bottom), values.data());
    fill_band(image, band, PixelValues<std::uint8_t>{values, stride, channels}, std::identity{});
  }
  return image;
}

}  // namespace

std::shared_ptr<TiledImage> load_tiled_image(const BitmapDescription& bitmap, const SourceLocation& where) {
  const auto shared = [](TiledImage image) { return std::make_shared<TiledImage>(std::move(image)); };
  if (bitmap.made) return shared(tile_made(*bitmap.made, bitmap, where));
  if (bitmap.encoded)
    return shared(tile_stored_image(read_stored_image(*bitmap.encoded), bitmap, {bitmap.encoded->name, 0}));
  std::string key = bitmap.raw ? "raw texture" : "texture";
  key += fmt::format(" {}", static_cast<int>(bitmap.channel));
  for (const float value : {bitmap.change.scale, bitmap.change.invert ? 1.0f : 0.0f, bitmap.change.exponent})
    key += fmt::format(" {}", std::bit_cast<std::uint32_t>(value));
  return cached(bitmap.file, key, [&] {
    const SourceLocation file{bitmap.file.string(), 0};
    if (std::optional<TiledImage> image = tile_halves(bitmap, file)) return shared(*std::move(image));
    if (std::optional<TiledImage> image = tile_rows(bitmap, file)) return shared(*std::move(image));
    return shared(tile_stored_image(read_stored_image(bitmap.file, bitmap.raw), bitmap, file));
  });
}

}  // namespace sheaf

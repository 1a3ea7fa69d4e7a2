// Converts an image, with rows from the top, to tiles of texels, with rows from the bottom.
#include "scene/compile/textures/texture_image.h"

#include "core/color/color.h"
#include "core/image/image.h"
#include "core/image/image_channels.h"
#include "core/io/file_cache.h"
#include "core/io/memory.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace sheaf {

namespace {

/// Calls f(texel index in tiled order, pixel index) for every pixel; pixels count from the upper left.
template <class F> void for_each_texel(const TiledImage& image, F&& f) {
  const int shift = tile_shift(image.format);
  const std::size_t mask = (std::size_t{1} << shift) - 1, width = image.width, height = image.height;
  for (std::size_t y = 0; y < height; ++y) {
    const std::size_t row = ((y >> shift) * image.tiles_per_row << 2 * shift) + ((y & mask) << shift);
    const std::size_t first_pixel = (height - 1 - y) * width;
    for (std::size_t x = 0; x < width; ++x) f(row + ((x >> shift) << 2 * shift) + (x & mask), first_pixel + x);
  }
}

/// Copies the selected `channels` of the image's `values` into texels of one or four values.
template <class T>
void fill_tiles(TiledImage& image, const std::vector<T>& values, std::size_t stride,
                const std::vector<std::size_t>& channels) {
  const std::size_t texel_bytes = (channels.size() == 1 ? 1 : 4) * sizeof(T);
  auto* tiles = reinterpret_cast<std::uint8_t*>(image.tiles.data());
  for_each_texel(image, [&](std::size_t texel, std::size_t pixel) {
    T copy[4] = {};
    for (std::size_t k = 0; k < channels.size(); ++k) copy[k] = values[pixel * stride + channels[k]];
    std::memcpy(tiles + texel * texel_bytes, copy, texel_bytes);
  });
}

/// Checks that the selected channels are finite, and decodes them if `decode`.
void prepare_floats(StoredImage& stored, const std::vector<std::size_t>& channels, bool decode,
                    const SourceLocation& where) {
  const std::size_t stride = stored.channels.size(), width = static_cast<std::size_t>(stored.width);
  for (std::size_t pixel = 0; pixel * stride < stored.floats.size(); ++pixel) {
    for (const std::size_t c : channels) {
      float& value = stored.floats[pixel * stride + c];
      if (!std::isfinite(value)) {
        throw SceneError(
            where,
            fmt::format("channel {} of the pixel in column {}, row {} (from the upper left) is not a finite number",
                        stored.channels[c], pixel % width, pixel / width));
      }
      if (decode) value = srgb_to_linear(value);
    }
  }
}

/// Converts all values to floats, decoded unless `linear`, and applies the color transform.
void change_values(StoredImage& stored, bool linear, const BitmapDescription::ColorTransform& change) {
  const bool decode = !linear && (stored.integers || !stored.bytes.empty());
  if (stored.floats.empty())
    for (const std::uint8_t byte : stored.bytes) stored.floats.push_back(static_cast<float>(byte) / 255.0f);
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

/// Indices of the channels that the texture uses: one or three. Replaces the image if it lacks alpha and that is used.
std::vector<std::size_t> select_channels(StoredImage& stored, BitmapDescription::Channel channel,
                                         const SourceLocation& where) {
  using Channel = BitmapDescription::Channel;
  const ColorChannels found = find_color_channels(stored.channels, where);
  if (channel == Channel::kColor) return found.channels;
  if (channel != Channel::kAlpha) {
    const auto index = static_cast<std::size_t>(channel) - static_cast<std::size_t>(Channel::kRed);
    return {found.channels[std::min(index, found.channels.size() - 1)]};
  }
  if (found.alpha) return {*found.alpha};
  stored = opaque_pixel();
  return {0};
}

TiledImage tile_stored_image(StoredImage stored, const BitmapDescription& bitmap, const SourceLocation& where) {
  const std::vector<std::size_t> channels = select_channels(stored, bitmap.channel, where);
  if (bitmap.change != BitmapDescription::ColorTransform{}) change_values(stored, bitmap.is_linear(), bitmap.change);
  const bool bytes = !stored.bytes.empty(), gray = channels.size() == 1;

  TiledImage image;
  image.width = static_cast<std::uint32_t>(stored.width);
  image.height = static_cast<std::uint32_t>(stored.height);
  image.format =
      bytes ? (gray ? TexelFormat::kByte1 : TexelFormat::kByte4) : (gray ? TexelFormat::kFloat1 : TexelFormat::kFloat4);
  const int shift = tile_shift(image.format);
  const auto tiles_along = [shift](std::uint32_t size) { return (size + (1u << shift) - 1) >> shift; };
  image.tiles_per_row = tiles_along(image.width);
  const std::size_t tiles = std::size_t{image.tiles_per_row} * tiles_along(image.height);
  if (tiles << 2 * shift > kMaxTexels) {
    throw SceneError(where,
                     fmt::format("an image of {} x {} pixels is too large for a texture (expected at most {} texels)",
                                 stored.width, stored.height, kMaxTexels));
  }
  const MemoryUse texels{"its texels", static_cast<double>(tiles) * sizeof(TexelTile), "use a smaller image"};
  check_memory(fmt::format("{} of {} x {} pixels",
                           where.file.empty() ? "a texture" : fmt::format("the texture '{}'", where.file), stored.width,
                           stored.height),
               {&texels, 1});
  image.tiles.resize(tiles);
  if (bytes) {
    fill_tiles(image, stored.bytes, stored.channels.size(), channels);
  } else {
    prepare_floats(stored, channels, stored.integers && !bitmap.is_linear(), where);
    fill_tiles(image, stored.floats, stored.channels.size(), channels);
  }
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

}  // namespace

TiledImage load_tiled_image(const BitmapDescription& bitmap, const SourceLocation& where) {
  if (bitmap.made) return tile_stored_image(stored_image(*bitmap.made), bitmap, where);
  if (bitmap.encoded) return tile_stored_image(read_stored_image(*bitmap.encoded), bitmap, {bitmap.encoded->name, 0});
  std::string key = bitmap.raw ? "raw texture" : "texture";
  key += fmt::format(" {}", static_cast<int>(bitmap.channel));
  for (const float value : {bitmap.change.scale, bitmap.change.invert ? 1.0f : 0.0f, bitmap.change.exponent})
    key += fmt::format(" {}", std::bit_cast<std::uint32_t>(value));
  return cached(bitmap.file, key, [&] {
    return tile_stored_image(read_stored_image(bitmap.file, bitmap.raw), bitmap, {bitmap.file.string(), 0});
  });
}

}  // namespace sheaf

// Images, and reading of image files.
#include "core/image/image.h"

#include "core/color/color_space.h"
#include "core/image/exr.h"
#include "core/image/exr_colors.h"
#include "core/image/image_formats.h"
#include "core/image/image_orientation.h"
#include "core/image/image_rows.h"
#include "core/image/image_source.h"
#include "core/io/error.h"
#include "core/io/memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

void check_file(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw SceneError({path.string(), 0}, "image file not found");
}

[[noreturn]] void refuse_image(const fs::path& path, const std::string& why) {
  throw SceneError({path.string(), 0}, "cannot read the image: " + why);
}

/// Rejects oversized tiles. Readers allocate a whole tile, and a file may claim huge tiles for a small image.
void check_tiles(const fs::path& path, const ImageHeader& header) {
  constexpr double kFewValues = 1 << 25, kMaxRatio = 4;
  if (header.tile_width == 0 && header.tile_height == 0) return;
  const auto whole_tiles = [](double side, double tile) { return std::ceil(side / tile) * tile; };
  const double channels = static_cast<double>(header.channels.size()), width = header.width, height = header.height;
  const double covered = whole_tiles(width, header.tile_width) * whole_tiles(height, header.tile_height) * channels;
  const double max_covered = std::max(kFewValues, kMaxRatio * width * height * channels);
  if (header.tile_width > 0 && header.tile_height > 0 && covered <= max_covered) return;
  throw SceneError({path.string(), 0},
                   fmt::format("the header claims tiles of {} x {} pixels for an image of {} x {} pixels",
                               header.tile_width, header.tile_height, header.width, header.height));
}

/// Opens an image other than OpenEXR and checks its header. `keeps_bytes`: 8-bit data will be read as bytes.
std::unique_ptr<ImageReader> open_image(ImageSource source, bool keeps_bytes) {
  const fs::path path = source.path();
  const ImageFormat& format = find_image_format(source);
  const auto file_bytes = static_cast<std::size_t>(std::max(source.size(), format.min_counted_bytes));
  std::string problem;
  std::unique_ptr<ImageReader> reader = format.open(std::move(source), problem);
  if (!reader) refuse_image(path, problem);
  const ImageHeader& header = reader->header();
  check_image_size(path, header.width, header.height, header.channels.size(), file_bytes);
  const std::size_t copies = header.orientation == 1 ? 1 : 2;
  check_image_memory(path, header.width, header.height, header.channels.size(),
                     copies * (keeps_bytes && header.holds_bytes ? 1 : sizeof(float)) + header.decoder_bytes);
  check_tiles(path, header);
  return reader;
}

/// Reads all pixels, rows from the top.
template <class Value> std::vector<Value> read_pixels(ImageReader& reader, const fs::path& path) {
  const ImageHeader& header = reader.header();
  const auto width = static_cast<std::size_t>(header.width), height = static_cast<std::size_t>(header.height);
  std::vector<Value> values(width * height * header.channels.size());
  std::string problem = kImageEndsEarly;
  if (!reader.read(values.data(), problem)) refuse_image(path, problem);
  if (header.orientation == 1) return values;
  return oriented(values, width, height, header.channels.size(), header.orientation);
}

/// Reads all pixels, 8-bit data as bytes.
StoredImage read_stored(ImageReader& reader, const fs::path& path) {
  const ImageHeader& header = reader.header();
  StoredImage image;
  image.width = is_transposed(header.orientation) ? header.height : header.width;
  image.height = is_transposed(header.orientation) ? header.width : header.height;
  image.channels = header.channels;
  image.integers = header.holds_integers;
  if (header.holds_bytes)
    image.bytes = read_pixels<std::uint8_t>(reader, path);
  else
    image.floats = read_pixels<float>(reader, path);
  return image;
}

}  // namespace

Image::Image(int image_width, int image_height, std::vector<std::string> names)
    : width(image_width),
      height(image_height),
      channels(std::move(names)),
      frame_width(image_width),
      frame_height(image_height) {
  data.resize(pixel_count() * channels.size());
}

int Image::find_channel(std::string_view name) const {
  const auto found = std::find(channels.begin(), channels.end(), name);
  return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

void check_image_size(const fs::path& file, long long width, long long height, std::size_t channels,
                      std::size_t file_bytes) {
  constexpr std::size_t kBestRatio = 2048, kSlack = std::size_t{1} << 20;
  const SourceLocation where{file.string(), 0};
  const std::string size = fmt::format("{} x {} pixels with {} channels", width, height, channels);
  if (width <= 0 || height <= 0 || channels == 0) throw SceneError(where, "the image is empty: " + size);
  if (width > kMaxImageSide || height > kMaxImageSide || channels > 4096) {
    throw SceneError(where, "the image is too large: " + size);
  }
  const std::size_t values = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * channels;
  if (values > kMaxImageBytes / sizeof(float)) throw SceneError(where, "the image is too large: " + size);
  if (file_bytes < kMaxImageBytes / kBestRatio && values > file_bytes * kBestRatio + kSlack) {
    throw SceneError(where, fmt::format("the header claims {}, but the file has only {} bytes", size, file_bytes));
  }
}

void check_image_memory(const fs::path& file, long long width, long long height, std::size_t channels,
                        std::size_t value_bytes) {
  const double values = static_cast<double>(width) * static_cast<double>(height) * static_cast<double>(channels);
  const MemoryUse pixels{"its pixels", values * static_cast<double>(value_bytes), "use a smaller image"};
  check_memory(fmt::format("the image '{}' of {} x {} pixels with {} channels", file.string(), width, height, channels),
               {&pixels, 1});
}

Image read_image(const fs::path& path) {
  check_file(path);
  if (is_exr(path)) return read_exr(path);
  const std::unique_ptr<ImageReader> reader = open_image(ImageSource(path), false);
  const ImageHeader& header = reader->header();
  Image image;
  image.width = image.frame_width = is_transposed(header.orientation) ? header.height : header.width;
  image.height = image.frame_height = is_transposed(header.orientation) ? header.width : header.height;
  image.channels = header.channels;
  image.data = read_pixels<float>(*reader, path);
  return image;
}

StoredImage read_stored_image(const fs::path& path, bool raw) {
  check_file(path);
  if (is_exr(path)) return read_exr_colors(path, raw);
  const std::unique_ptr<ImageReader> reader = open_image(ImageSource(path), true);
  StoredImage image = read_stored(*reader, path);
  if (reader->header().xyz && !raw) convert_to_rec709(image.floats, kXyzSpace, image.channels.size());
  return image;
}

StoredImage read_stored_image(const EncodedImage& image) {
  const std::unique_ptr<ImageReader> reader = open_image(ImageSource(image), true);
  return read_stored(*reader, image.name);
}

ImageRows::ImageRows(std::unique_ptr<ImageReader> reader, fs::path path)
    : reader_(std::move(reader)), path_(std::move(path)) {}

std::optional<ImageRows> ImageRows::open(const fs::path& path) {
  check_file(path);
  if (is_exr(path)) return std::nullopt;
  std::unique_ptr<ImageReader> reader = open_image(ImageSource(path), true);
  if (!reader->has_rows() || reader->header().orientation != 1) return std::nullopt;
  return ImageRows(std::move(reader), path);
}

void ImageRows::read(int count, std::uint8_t* out) {
  std::string problem = kImageEndsEarly;
  if (!reader_->read_rows(count, out, problem)) refuse_image(path_, problem);
}

double stored_image_bytes(const fs::path& path) {
  const auto bytes = [](double width, double height, std::size_t channels, std::size_t value_bytes) {
    return width * height * static_cast<double>(channels * value_bytes);
  };
  try {
    check_file(path);
    if (is_exr(path)) {
      const ExrHeader header = read_exr_header(path);
      const PixelRect& frame = header.frame;
      const double width = frame.x1, height = frame.y1;
      return bytes(width - frame.x0, height - frame.y0, header.channels.size(), sizeof(float));
    }
    const std::unique_ptr<ImageReader> reader = open_image(ImageSource(path), true);
    const ImageHeader& header = reader->header();
    return bytes(header.width, header.height, header.channels.size(), header.holds_bytes ? 1 : sizeof(float));
  } catch (const Error&) { return 0; }
}

}  // namespace sheaf

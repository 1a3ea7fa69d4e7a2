// Reading of image files and writing of PNG, by the library behind core/image_library.h.
#include "core/image.h"

#include "core/color.h"
#include "core/color_space.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/exr_colors.h"
#include "core/image_corrections.h"
#include "core/image_library.h"
#include "core/image_source.h"
#include "core/memory.h"
#include "core/output_file.h"
#include "core/png.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

std::uint8_t quantize(float value) {
  if (!(value > 0)) return 0;
  return static_cast<std::uint8_t>(std::lround(std::min(value, 1.0f) * 255.0f));
}

/// Source channels of a PNG: one or three for colour, and one for alpha, or -1 without alpha.
struct PngChannels {
  std::vector<int> color;
  int alpha = -1;
};

/// The alpha of a pixel in a PNG. Light that adds to the background, as of a flame, has less alpha than colour. A PNG
/// cannot express that: its alpha is that of the brightest colour, which keeps the image over black.
float png_alpha(const float* pixel, const PngChannels& chosen) {
  float brightest = 0;
  for (const int c : chosen.color) brightest = std::max(brightest, pixel[c]);
  return std::max(pixel[chosen.alpha], std::min(brightest, 1.0f));
}

PngChannels choose_channels(const Image& image) {
  PngChannels chosen;
  const int red = image.find_channel("R"), green = image.find_channel("G"), blue = image.find_channel("B");
  if (red >= 0 && green >= 0 && blue >= 0) {
    chosen.color = {red, green, blue};
  } else {
    chosen.color = {std::max(red, 0)};
  }
  const int alpha = image.find_channel("A");
  if (alpha < 0 || alpha == chosen.color[0]) return chosen;
  chosen.alpha = alpha;
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    if (quantize(png_alpha(&image.data[i * image.channels.size()], chosen)) != 255) return chosen;
  chosen.alpha = -1;
  return chosen;
}

std::vector<std::uint8_t> encode(const Image& image, const PngChannels& chosen) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(image.pixel_count() * (chosen.color.size() + 1));
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float* pixel = &image.data[i * image.channels.size()];
    const float alpha = chosen.alpha < 0 ? 1.0f : png_alpha(pixel, chosen);
    const float scale = alpha > 0 ? 1 / alpha : 0.0f;
    for (const int c : chosen.color) bytes.push_back(quantize(linear_to_srgb(pixel[c] * scale)));
    if (chosen.alpha >= 0) bytes.push_back(quantize(alpha));
  }
  return bytes;
}

void check_file(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw SceneError({path.string(), 0}, "image file not found");
}

[[noreturn]] void refuse_image(const fs::path& path, const std::string& why) {
  throw SceneError({path.string(), 0}, "cannot read the image: " + why);
}

/// The first line of a message of the library, which may repeat it for every row.
std::string first_line(const std::string& remark) { return remark.substr(0, remark.find('\n')); }

/// Rejects oversized tiles. The library allocates a whole row of tiles, and a file may claim huge tiles for a small
/// image.
void check_tiles(const fs::path& path, const ImageHeader& header) {
  constexpr double kFewValues = 1 << 25, kMaxRatio = 4;
  if (header.tile_width == 0 && header.tile_height == 0) return;
  const auto whole_tiles = [](double side, double tile) { return std::ceil(side / tile) * tile; };
  const double channels = header.channel_count, width = header.width, height = header.height;
  const double covered = whole_tiles(width, header.tile_width) * whole_tiles(height, header.tile_height) * channels;
  const double max_covered = std::max(kFewValues, kMaxRatio * width * height * channels);
  if (header.tile_width > 0 && header.tile_height > 0 && covered <= max_covered) return;
  const auto size = [](int x, int y) { return std::to_string(x) + " x " + std::to_string(y) + " pixels"; };
  throw SceneError({path.string(), 0}, "the header claims tiles of " + size(header.tile_width, header.tile_height) +
                                           " for an image of " + size(header.width, header.height));
}

/// An open image file, other than OpenEXR, with a valid header.
struct OpenImage {
  std::unique_ptr<ImageReader> reader;
  int orientation;  ///< see ImageCorrections
  bool xyz;
};

/// Opens an image and checks its header. `keeps_bytes`: 8-bit data will be read as bytes.
OpenImage open_image(ImageSource source, bool keeps_bytes) {
  const fs::path& path = source.path();
  const SourceLocation where{path.string(), 0};
  const std::string format = checked_image_format(source);
  ImageCorrections corrections;
  if (source.memory() != nullptr)
    corrections.bytes = source.memory()->bytes;
  else
    corrections = find_corrections(path, format);
  std::string problem;
  std::unique_ptr<ImageReader> reader =
      image_library().open(path.string(), format, problem, std::move(corrections.bytes));
  if (!reader) refuse_image(path, first_line(problem));
  const ImageHeader& header = reader->header();
  check_image_size(path, header.width, header.height, static_cast<std::size_t>(std::max(header.channel_count, 0)),
                   counted_image_bytes(source, format));
  const std::size_t copies = corrections.orientation == 1 ? 1 : 2;
  check_image_memory(path, header.width, header.height, static_cast<std::size_t>(header.channel_count),
                     copies * (keeps_bytes && header.holds_bytes ? 1 : sizeof(float)));
  check_tiles(path, header);
  if (header.depth > 1 || header.deep) throw SceneError(where, "volume and deep images are not supported");
  if (header.channels.size() != static_cast<std::size_t>(header.channel_count)) {
    throw SceneError(where, "the image's channels have no names");
  }
  return {std::move(reader), corrections.orientation, corrections.xyz};
}

/// Reads all pixels, rows from the top. Rejects truncated JPEG files: the library fills their lower part with grey and
/// only leaves a remark.
template <class Value> std::vector<Value> read_pixels(const OpenImage& open, const fs::path& path) {
  const ImageHeader& header = open.reader->header();
  const auto width = static_cast<std::size_t>(header.width), height = static_cast<std::size_t>(header.height);
  std::vector<Value> values(width * height * header.channels.size());
  std::string remark;
  const bool complete = open.reader->read(values.data(), remark);
  if (!complete || remark.find("remature end") != std::string::npos)
    refuse_image(path, remark.empty() ? "the file is damaged or ends too early" : first_line(remark));
  if (open.orientation == 1) return values;
  return oriented(values, width, height, header.channels.size(), open.orientation);
}

/// Reads all pixels, 8-bit data as bytes.
StoredImage read_stored(const OpenImage& open, const fs::path& path) {
  const ImageHeader& header = open.reader->header();
  StoredImage image;
  image.width = is_transposed(open.orientation) ? header.height : header.width;
  image.height = is_transposed(open.orientation) ? header.width : header.height;
  image.channels = header.channels;
  image.integers = header.holds_integers;
  if (header.holds_bytes)
    image.bytes = read_pixels<std::uint8_t>(open, path);
  else
    image.floats = read_pixels<float>(open, path);
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
  const std::string size =
      std::to_string(width) + " x " + std::to_string(height) + " pixels with " + std::to_string(channels) + " channels";
  if (width <= 0 || height <= 0 || channels == 0) throw SceneError(where, "the image is empty: " + size);
  if (width > kMaxImageSide || height > kMaxImageSide || channels > 4096) {
    throw SceneError(where, "the image is too large: " + size);
  }
  const std::size_t values = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * channels;
  if (values > kMaxImageBytes / sizeof(float)) throw SceneError(where, "the image is too large: " + size);
  if (file_bytes < kMaxImageBytes / kBestRatio && values > file_bytes * kBestRatio + kSlack) {
    throw SceneError(where,
                     "the header claims " + size + ", but the file has only " + std::to_string(file_bytes) + " bytes");
  }
}

void check_image_memory(const fs::path& file, long long width, long long height, std::size_t channels,
                        std::size_t value_bytes) {
  const double values = static_cast<double>(width) * static_cast<double>(height) * static_cast<double>(channels);
  const MemoryUse pixels{"its pixels", values * static_cast<double>(value_bytes), "use a smaller image"};
  check_memory("the image '" + file.string() + "' of " + std::to_string(width) + " x " + std::to_string(height) +
                   " pixels with " + std::to_string(channels) + " channels",
               {&pixels, 1});
}

std::vector<unsigned char> encode_png(const Image& image, int level, const std::string& description) {
  const auto fail = [](const std::string& why) {
    return Error(ExitCode::kRuntime, "cannot encode a PNG file: " + why);
  };
  if (image.pixel_count() == 0 || image.channels.empty()) throw fail("the image is empty");
  const PngChannels chosen = choose_channels(image);
  const std::vector<std::uint8_t> bytes = encode(image, chosen);
  const bool has_alpha = chosen.alpha >= 0;
  const int count = static_cast<int>(chosen.color.size()) + (has_alpha ? 1 : 0);
  std::string problem;
  std::vector<unsigned char> png = image_library().encode_png(
      {image.width, image.height, count, has_alpha, bytes.data(), description}, level, problem);
  if (png.empty()) throw fail(problem);
  return png;
}

void write_png(const fs::path& path, const Image& image, const std::string& description) {
  OutputFile file(path);
  const std::vector<unsigned char> png = [&] {
    try {
      return encode_png(image, kPngCompression, description);
    } catch (const Error& error) {
      throw Error(ExitCode::kOutput, "cannot write '" + path.string() + "': " + error.what());
    }
  }();
  file.stream().write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  file.commit();
}

Image read_image(const fs::path& path) {
  check_file(path);
  if (is_exr(path)) return read_exr(path);
  const OpenImage open = open_image(ImageSource(path), false);
  const ImageHeader& header = open.reader->header();
  Image image;
  image.width = image.frame_width = is_transposed(open.orientation) ? header.height : header.width;
  image.height = image.frame_height = is_transposed(open.orientation) ? header.width : header.height;
  image.channels = header.channels;
  image.data = read_pixels<float>(open, path);
  return image;
}

StoredImage read_stored_image(const fs::path& path, bool raw) {
  check_file(path);
  if (is_exr(path)) return read_exr_colors(path, raw);
  const OpenImage open = open_image(ImageSource(path), true);
  StoredImage image = read_stored(open, path);
  if (open.xyz && !raw && image.channels.size() >= 3) convert_to_rec709(image.floats, kXyzSpace, image.channels.size());
  return image;
}

StoredImage read_stored_image(const EncodedImage& image) {
  return read_stored(open_image(ImageSource(image), true), image.name);
}

}  // namespace sheaf

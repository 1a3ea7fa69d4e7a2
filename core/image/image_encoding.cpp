#include "core/image/image_encoding.h"

#include "core/color/color.h"
#include "core/image/display_channels.h"
#include "core/image/formats/jpeg.h"
#include "core/image/formats/png.h"
#include "core/image/formats/tiff.h"
#include "core/io/error.h"
#include "core/io/output_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

template <class Integer> Integer quantize(float value) {
  if (!(value > 0)) return 0;
  return static_cast<Integer>(
      std::lround(std::min(value, 1.0f) * static_cast<float>(std::numeric_limits<Integer>::max())));
}

/// Whether an 8-bit file shows any pixel as transparent.
bool is_transparent(const Image& image, const DisplayChannels& channels) {
  if (channels.alpha < 0) return false;
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    if (quantize<std::uint8_t>(display_alpha(&image.data[i * image.channels.size()], channels)) != 255) return true;
  return false;
}

/// Values of all pixels. Colors are straight if there is alpha, and over black otherwise.
template <class Integer> std::vector<Integer> quantized(const Image& image, const DisplayChannels& channels) {
  std::vector<Integer> values;
  values.reserve(image.pixel_count() * (channels.color.size() + 1));
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float* pixel = &image.data[i * image.channels.size()];
    const float alpha = display_alpha(pixel, channels);
    const float scale = alpha > 0 ? 1 / alpha : 0.0f;
    for (const int c : channels.color) values.push_back(quantize<Integer>(linear_to_srgb(pixel[c] * scale)));
    if (channels.alpha >= 0) values.push_back(quantize<Integer>(alpha));
  }
  return values;
}

const char* name_of(IntegerFormat format) {
  return format == IntegerFormat::kJpeg ? "JPEG" : format == IntegerFormat::kTiff ? "TIFF" : "PNG";
}

template <class Integer>
std::vector<unsigned char> encode(const Image& image, const DisplayChannels& channels, const IntegerEncoding& encoding,
                                  std::string& problem) {
  const std::vector<Integer> values = quantized<Integer>(image, channels);
  const bool has_alpha = channels.alpha >= 0;
  const int count = static_cast<int>(channels.color.size()) + (has_alpha ? 1 : 0);
  constexpr int kBits = std::numeric_limits<Integer>::digits;
  const IntegerPixels pixels{image.width, image.height, count, has_alpha, kBits, values.data()};
  switch (encoding.format) {
    case IntegerFormat::kJpeg:
      return encode_jpeg(pixels, encoding.quality, encoding.description, problem);
    case IntegerFormat::kTiff:
      return encode_tiff(pixels, encoding.description, problem);
    case IntegerFormat::kPng:
      break;
  }
  return encode_png(pixels, encoding.level, encoding.description, problem);
}

}  // namespace

std::vector<unsigned char> encode_image(const Image& image, const IntegerEncoding& encoding) {
  const auto fail = [&](const std::string& why) {
    return Error(ExitCode::kRuntime, fmt::format("cannot encode a {} file: {}", name_of(encoding.format), why));
  };
  if (image.pixel_count() == 0 || image.channels.empty()) throw fail("the image is empty");
  DisplayChannels channels = display_channels(image);
  if (encoding.format == IntegerFormat::kJpeg || !is_transparent(image, channels)) channels.alpha = -1;
  std::string problem;
  std::vector<unsigned char> bytes = encoding.format == IntegerFormat::kTiff
                                         ? encode<std::uint16_t>(image, channels, encoding, problem)
                                         : encode<std::uint8_t>(image, channels, encoding, problem);
  if (bytes.empty()) throw fail(problem);
  return bytes;
}

void write_encoded_image(const fs::path& path, const Image& image, const IntegerEncoding& encoding) {
  OutputFile file(path);
  const std::vector<unsigned char> bytes = [&] {
    try {
      return encode_image(image, encoding);
    } catch (const Error& error) {
      throw Error(ExitCode::kOutput, fmt::format("cannot write '{}': {}", path.string(), error.what()));
    }
  }();
  file.stream().write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.commit();
}

void write_png(const fs::path& path, const Image& image, const std::string& description) {
  IntegerEncoding encoding;
  encoding.description = description;
  write_encoded_image(path, image, encoding);
}

}  // namespace sheaf

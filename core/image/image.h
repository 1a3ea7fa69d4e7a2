// Images in memory with any number of named float channels; reading of image files of many formats, writing of PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// A rectangle of pixels with named channels, part of a frame that may be larger.
struct Image {
  int width = 0, height = 0;              ///< pixels of the image
  std::vector<std::string> channels;      ///< names, e.g. "R" or "variance.G"; each once
  std::vector<float> data;                ///< interleaved, row by row from the top: height * width * channels values
  int x0 = 0, y0 = 0;                     ///< position of the upper left pixel in the frame
  int frame_width = 0, frame_height = 0;  ///< size of the whole frame; equal to width and height without crop

  Image() = default;
  /// An image of zeros that fills its frame.
  Image(int image_width, int image_height, std::vector<std::string> names);

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  /// The index of a channel, or -1 if there is no channel of this name.
  int find_channel(std::string_view name) const;
  /// One value; x, y count from the image's own upper left pixel, c is a channel index. Not checked.
  float& at(int x, int y, int c) { return data[offset(x, y, c)]; }
  float at(int x, int y, int c) const { return data[offset(x, y, c)]; }

 private:
  std::size_t offset(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               channels.size() +
           static_cast<std::size_t>(c);
  }
};

/// An image as its file stores it: 8-bit data as bytes, all other data as floats. One of the two vectors is empty.
struct StoredImage {
  int width = 0, height = 0;          ///< pixels
  std::vector<std::string> channels;  ///< names
  std::vector<std::uint8_t> bytes;    ///< interleaved, row by row from the top
  std::vector<float> floats;          ///< likewise; integers of 16 bits and more are divided by their maximum
  bool integers = false;              ///< the file holds integers, by convention sRGB-encoded colors
};

/// The bytes of an image file in memory, for example one that is part of another file.
struct EncodedImage {
  std::vector<std::uint8_t> bytes;
  std::string name;  ///< for messages
};

/// Limits of image files: pixels per side, and bytes as floats. Larger images are rejected, whatever the header claims.
inline constexpr int kMaxImageSide = 1 << 16;
inline constexpr std::size_t kMaxImageBytes = std::size_t{1} << 34;

/// Throws SceneError if an image is empty, exceeds the limits above, or is too large for a file of `file_bytes` bytes
/// even at the best compression ratio of image formats.
void check_image_size(const std::filesystem::path& file, long long width, long long height, std::size_t channels,
                      std::size_t file_bytes);

/// Throws Error (exit code 1) if the available memory does not suffice for an image with `value_bytes` bytes per value.
void check_image_memory(const std::filesystem::path& file, long long width, long long height, std::size_t channels,
                        std::size_t value_bytes);

/// Writes the channels R, G and B as an 8-bit PNG with the sRGB curve. If one of them is missing, writes R, or else the
/// first channel, as gray. Values are clamped to [0, 1] and rounded to nearest; NaN becomes 0. Alpha is kept if a
/// channel A is not 1 everywhere; colors are then assumed to be premultiplied. Where a color exceeds alpha, alpha is
/// raised to the brightest color, at most 1. Writes only the pixels of the image, not its frame. `description`: text
/// in the header of the file. Throws Error (exit code 4).
void write_png(const std::filesystem::path& path, const Image& image, const std::string& description = {});

/// Reads the first image of an OpenEXR file, by read_exr(), or of a file in a format of image_formats(). Integers are
/// mapped to [0, 1] without linearization; alpha is kept as stored. Applies the orientation of Radiance and TIFF files.
/// Throws SceneError if the file is missing, malformed, or beyond the limits.
Image read_image(const std::filesystem::path& path);

/// Reads the colors of the same files. 8-bit data stay bytes, and OpenEXR files are read by read_exr_colors(). Unless
/// `raw`, floats in other color spaces are converted to linear Rec.709. Throws like read_image().
StoredImage read_stored_image(const std::filesystem::path& path, bool raw = false);

/// The same for a PNG, JPEG or WebP file in memory. Throws SceneError for other formats.
StoredImage read_stored_image(const EncodedImage& image);

/// The memory of the values that read_stored_image() returns for a file, in bytes, according to its header. 0 if it
/// cannot be read.
double stored_image_bytes(const std::filesystem::path& path);

}  // namespace sheaf

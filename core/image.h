// Images in memory: any number of named float channels. Reading picture files of many formats, writing PNG.
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
  int width = 0, height = 0;              ///< pixels that are there
  std::vector<std::string> channels;      ///< names, e.g. "R" or "variance.G"; each once
  std::vector<float> data;                ///< interleaved, row by row from the top: height * width * channels values
  int x0 = 0, y0 = 0;                     ///< where the upper left pixel lies in the frame
  int frame_width = 0, frame_height = 0;  ///< the whole picture; equal to width and height if nothing was cropped

  Image() = default;
  /// An image of zeros that fills its frame.
  Image(int image_width, int image_height, std::vector<std::string> names);

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  /// The channel's index, or -1 if there is none of this name.
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

/// A picture as its file stores it: 8-bit data as bytes, everything else as floats. One of the two is empty.
struct Picture {
  int width = 0, height = 0;          ///< pixels
  std::vector<std::string> channels;  ///< names
  std::vector<std::uint8_t> bytes;    ///< interleaved, row by row from the top
  std::vector<float> floats;          ///< likewise; integers of 16 bits and more divided by the largest
  bool integers = false;  ///< stored as integers, which by convention means colours encoded by the sRGB curve
};

/// Larger images are refused, whatever a file's header claims: pixels per side and bytes as floats.
inline constexpr int kMaxImageSide = 1 << 16;
inline constexpr std::size_t kMaxImageBytes = std::size_t{1} << 34;

/// Throws SceneError if an image of this size is beyond the limits above, empty, or larger than a file of `file_bytes`
/// bytes can hold at the best ratio that picture formats compress to.
void check_image_size(const std::filesystem::path& file, long long width, long long height, std::size_t channels,
                      std::size_t file_bytes);

/// Throws Error (exit code 1) if there is not the memory for an image whose values take `value_bytes` bytes each.
void check_image_memory(const std::filesystem::path& file, long long width, long long height, std::size_t channels,
                        std::size_t value_bytes);

/// Writes the channels R, G and B (or the first channel as grey, if there is no R) as an 8-bit PNG with the sRGB curve.
/// Values are clamped to [0, 1] and rounded to nearest; NaN becomes 0. Alpha is kept if there is an A that is not 1
/// everywhere; colours are then taken as premultiplied. Only the pixels that are there are written, not the frame.
/// `description`: text of the file's header. Throws Error (exit code 4).
void write_png(const std::filesystem::path& path, const Image& image, const std::string& description = {});

/// Reads a picture file of one of the formats of checked_picture_format() or of OpenEXR, which goes through read_exr();
/// the first picture if there are several. Integers come out in [0, 1] as stored, not linearised; alpha as stored.
/// Radiance and TIFF files are turned the way up that they say. Throws SceneError if the file is missing, malformed, or
/// beyond the limits.
Image read_image(const std::filesystem::path& path);

/// Reads the same files for their colours: 8-bit data are kept as bytes, and OpenEXR files go through
/// read_exr_picture(). Floats in other spaces than linear Rec.709 are converted to it unless `raw`. Throws as
/// read_image() does.
Picture read_picture(const std::filesystem::path& path, bool raw = false);

}  // namespace sheaf

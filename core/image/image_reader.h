// Reading and encoding of image files, whatever their format and library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sheaf {

/// The header of an image file.
struct ImageHeader {
  int width = 0, height = 0;          ///< pixels
  std::vector<std::string> channels;  ///< names
  bool holds_bytes = false;           ///< values are unsigned 8-bit integers
  bool holds_integers = false;
  /// Orientation of TIFF and EXIF: the position of the first row and of the first column of the stored pixels. 1 top
  /// and left, 2 top and right, 3 bottom and right, 4 bottom and left. With rows and columns exchanged: 5 left and top,
  /// 6 right and top, 7 right and bottom, 8 left and bottom.
  int orientation = 1;
  bool xyz = false;                     ///< the colors are CIE XYZ
  int tile_width = 0, tile_height = 0;  ///< pixels, as claimed by the file, unchecked; 0: scan lines
  std::size_t decoder_bytes = 0;        ///< memory that reading takes besides the pixels, bytes per value
};

/// An open image file.
class ImageReader {
 public:
  ImageReader() = default;
  virtual ~ImageReader() = default;
  ImageReader(const ImageReader&) = delete;
  ImageReader& operator=(const ImageReader&) = delete;

  const ImageHeader& header() const { return header_; }
  /// Reads all values, once, interleaved, in the order of the file: as bytes, if the header says that the file holds
  /// bytes, or as floats. Unsigned integers become floats in [0, 1]. On failure returns false and sets `problem`.
  virtual bool read(std::uint8_t* out, std::string& problem);
  virtual bool read(float* out, std::string& problem) = 0;
  /// Whether read_rows() can be used instead: the file holds bytes, in rows from the top.
  virtual bool has_rows() const { return false; }
  /// Reads the next `count` rows of bytes. On failure returns false and sets `problem`.
  virtual bool read_rows(int count, std::uint8_t* out, std::string& problem);

 protected:
  void set_header(int width, int height, std::vector<std::string> channels);

  ImageHeader header_;
};

/// A reader of files that hold unsigned integers of 8 or 16 bits.
class IntegerReader : public ImageReader {
 public:
  bool read(std::uint8_t* out, std::string& problem) final { return decode(out, problem); }
  bool read(float* out, std::string& problem) final;

 protected:
  void set_header(int width, int height, std::vector<std::string> channels, int bits);
  /// Reads all values as integers of 1 or 2 bytes in the byte order of the machine. On failure returns false and sets
  /// `problem`.
  virtual bool decode(unsigned char* out, std::string& problem) = 0;
};

/// Names of the channels of an image without names: Y, or R, G, B, A and channel4.
std::vector<std::string> default_channel_names(int count);

/// Pixels for a file of integers.
struct IntegerPixels {
  int width, height, channels;
  bool has_alpha;      ///< the last channel is alpha; colors are not premultiplied
  int bits;            ///< per value: 8 or 16
  const void* values;  ///< std::uint8_t or std::uint16_t, interleaved, row by row from the top, sRGB

  std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels) * static_cast<std::size_t>(bits / 8);
  }
};

}  // namespace sheaf

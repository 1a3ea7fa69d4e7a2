// Reading and encoding of image files, whatever their format and library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sheaf {

/// The header of an image file.
struct ImageHeader {
  int width = 0, height = 0, depth = 1;  ///< pixels
  int channel_count = 0;
  std::vector<std::string> channels;  ///< names
  bool deep = false;                  ///< pixels hold any number of samples
  bool holds_bytes = false;           ///< values are unsigned 8-bit integers
  bool holds_integers = false;
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
  virtual const ImageHeader& header() const = 0;
  /// Reads all values, once, interleaved, row by row from the top: as bytes, if the header says that the file holds
  /// bytes, or as floats. Integers become floats in [0, 1]. Returns whether everything was read, and sets `remark` to
  /// the messages of the library.
  virtual bool read(std::uint8_t* out, std::string& remark) = 0;
  virtual bool read(float* out, std::string& remark) = 0;
};

/// A reader of files that hold unsigned integers of 8 or 16 bits.
class IntegerReader : public ImageReader {
 public:
  const ImageHeader& header() const final { return header_; }
  bool read(std::uint8_t* out, std::string& remark) final { return decode(out, remark); }
  bool read(float* out, std::string& remark) final;

 protected:
  void set_header(int width, int height, std::vector<std::string> channels, int bits);
  /// Reads all values as integers of 1 or 2 bytes in the byte order of the machine. On failure returns false and sets
  /// `problem`.
  virtual bool decode(unsigned char* out, std::string& problem) = 0;

  ImageHeader header_;
};

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

// Header fields of Radiance and TIFF files that OpenImageIO ignores or misreads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// Corrections to the data that OpenImageIO reads from a file.
struct ImageCorrections {
  /// Orientation of TIFF and EXIF: the position of the first row and of the first column of the stored pixels. 1 top
  /// and left, 2 top and right, 3 bottom and right, 4 bottom and left. With rows and columns exchanged: 5 left and top,
  /// 6 right and top, 7 right and bottom, 8 left and bottom.
  int orientation = 1;
  bool xyz = false;                 ///< the colors are CIE XYZ
  std::vector<std::uint8_t> bytes;  ///< data that the library reads instead of the file; empty: reads the file
};

/// Finds the corrections for a file of `format`, as returned by checked_image_format(). For Radiance files (Ward,
/// "The RADIANCE Picture File Format"): the resolution string, such as "-Y 512 +X 1024", in its eight forms, and the
/// format 32-bit_rle_xyze. For TIFF files (revision 6.0): Orientation, and BitsPerSample, which defaults to 1.
ImageCorrections find_corrections(const std::filesystem::path& file, const std::string& format);

/// Whether the orientation exchanges rows and columns, and so width and height.
inline bool is_transposed(int orientation) { return orientation >= 5; }

/// Reorders `width` x `height` stored pixels of `channels` values into rows from the top.
template <class Value>
std::vector<Value> oriented(const std::vector<Value>& stored, std::size_t width, std::size_t height,
                            std::size_t channels, int orientation) {
  const bool transposed = is_transposed(orientation);
  const std::size_t out_width = transposed ? height : width, out_height = transposed ? width : height;
  // The stored rows are in reverse order if the first one lies at the bottom or to the right; likewise the columns.
  const bool reverse_rows = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const bool reverse_columns = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  std::vector<Value> out;
  out.reserve(stored.size());
  for (std::size_t y = 0; y < out_height; ++y)
    for (std::size_t x = 0; x < out_width; ++x) {
      std::size_t row = transposed ? x : y, column = transposed ? y : x;
      if (reverse_rows) row = height - 1 - row;
      if (reverse_columns) column = width - 1 - column;
      const Value* const pixel = &stored[(row * width + column) * channels];
      out.insert(out.end(), pixel, pixel + channels);
    }
  return out;
}

}  // namespace sheaf

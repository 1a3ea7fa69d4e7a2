// What the headers of Radiance and TIFF files say that OpenImageIO does not act upon, or gets wrong.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// How to put right what the library reads of a file.
struct PictureCorrections {
  /// Of TIFF and EXIF: where the first row and the first column of the stored pixels lie. 1 top and left, 2 top and
  /// right, 3 bottom and right, 4 bottom and left; with columns for rows 5 left and top, 6 right and top, 7 right and
  /// bottom, 8 left and bottom.
  int orientation = 1;
  bool xyz = false;                 ///< the colours are CIE XYZ
  std::vector<std::uint8_t> bytes;  ///< what the library is to read in place of the file; empty: the file
};

/// For a file of `format`, as checked_picture_format() names it. Of Radiance files the resolution string, such as
/// "-Y 512 +X 1024", which has eight forms, and the format 32-bit_rle_xyze (Ward, "The RADIANCE Picture File Format").
/// Of TIFF files (revision 6.0) Orientation, and BitsPerSample, which is 1 where it is missing.
PictureCorrections find_corrections(const std::filesystem::path& file, const std::string& format);

/// Whether the orientation has columns for rows: width and height change places.
inline bool is_transposed(int orientation) { return orientation >= 5; }

/// Puts `width` x `height` pixels of `channels` values, as stored, into rows from the top.
template <class Value>
std::vector<Value> oriented(const std::vector<Value>& stored, std::size_t width, std::size_t height,
                            std::size_t channels, int orientation) {
  const bool transposed = is_transposed(orientation);
  const std::size_t out_width = transposed ? height : width, out_height = transposed ? width : height;
  // Rows are counted from the far side where the first one lies at the bottom or to the right; so are columns.
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

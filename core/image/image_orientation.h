// Orientations of stored pixels, as TIFF and EXIF number them.
#pragma once

#include <cstddef>
#include <vector>

namespace sheaf {

/// Whether the orientation exchanges rows and columns, and so width and height. See ImageHeader.
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

// Makes PNG files of all kinds byte by byte (ISO/IEC 15948), so that tests know their exact content.
#pragma once

#include "core/io/inflate.h"
#include "tests/support/files/deflate.h"

#include <cstdint>
#include <string>
#include <vector>

namespace sheaf::test {

/// A number of 4 bytes in big-endian order.
inline std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xffu);
  return bytes;
}

inline std::string png_chunk(const std::string& name, const std::string& data) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + name + data + big_endian(check_sum(name + data));
}

/// What a PNG file holds. Color types: 0 gray, 2 RGB, 3 palette, 4 gray with alpha, 6 RGBA.
struct PngSample {
  int width = 1, height = 1;
  int color_type = 0, bits = 8;  ///< bits per value
  std::vector<int> values;       ///< as stored, interleaved, row by row from the top
  std::string chunks;            ///< between the header and the pixels, by png_chunk()
  bool interlaced = false;
};

/// The rows of every `dx`th column and `dy`th row from (x0, y0) on, without filter.
inline std::string png_rows(const PngSample& sample, int x0, int y0, int dx, int dy) {
  const int channels = sample.color_type == 2 ? 3 : sample.color_type == 4 ? 2 : sample.color_type == 6 ? 4 : 1;
  std::string rows;
  if (x0 >= sample.width) return rows;
  for (int y = y0; y < sample.height; y += dy) {
    rows += '\0';
    int free_bits = 0;
    for (int x = x0; x < sample.width; x += dx)
      for (int c = 0; c < channels; ++c) {
        const int value = sample.values[static_cast<std::size_t>((y * sample.width + x) * channels + c)];
        for (int bit = sample.bits - 1; bit >= 0; --bit) {
          if (free_bits == 0) rows += '\0', free_bits = 8;
          rows.back() = static_cast<char>(rows.back() | (value >> bit & 1) << --free_bits);
        }
      }
  }
  return rows;
}

inline std::string png_file(const PngSample& sample) {
  constexpr int kAdam7[][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                               {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};  // x0, y0, dx, dy of each pass
  std::string rows;
  if (sample.interlaced)
    for (const auto& [x0, y0, dx, dy] : kAdam7) rows += png_rows(sample, x0, y0, dx, dy);
  else
    rows = png_rows(sample, 0, 0, 1, 1);
  std::string header =
      big_endian(static_cast<std::uint32_t>(sample.width)) + big_endian(static_cast<std::uint32_t>(sample.height));
  for (const int byte : {sample.bits, sample.color_type, 0, 0, sample.interlaced ? 1 : 0})
    header += static_cast<char>(byte);
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + sample.chunks + png_chunk("IDAT", deflated(rows)) +
         png_chunk("IEND", "");
}

}  // namespace sheaf::test

// Writes small image files in several formats byte by byte, so that tests know their exact content.
#pragma once

#include "tests/support/temporary_folder.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace sheaf {

/// Appends the lowest bytes of a number in little-endian order.
inline void append_little(std::string& out, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xffu);
}

/// Writes PGM (one channel) or PPM (three channels). `values` are interleaved, top left first; 16 bits if `max_value` >
/// 255.
inline void write_pnm(const std::filesystem::path& path, int width, int height, int channels, int max_value,
                      const std::vector<int>& values) {
  std::string bytes = std::string(channels == 1 ? "P5 " : "P6 ") + std::to_string(width) + " " +
                      std::to_string(height) + " " + std::to_string(max_value) + "\n";
  for (const int v : values) {
    if (max_value > 255) bytes += static_cast<char>(v >> 8);
    bytes += static_cast<char>(v & 0xff);
  }
  write_bytes(path, bytes);
}

/// Writes uncompressed TGA of 24 or 32 bits; `values` are R, G, B (and A), top left first.
inline void write_tga(const std::filesystem::path& path, int width, int height, int channels,
                      const std::vector<int>& values) {
  std::string bytes{0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  append_little(bytes, static_cast<std::uint32_t>(width), 2);
  append_little(bytes, static_cast<std::uint32_t>(height), 2);
  bytes += static_cast<char>(8 * channels);
  bytes += static_cast<char>(channels == 4 ? 0x28 : 0x20);
  for (std::size_t i = 0; i < values.size(); i += static_cast<std::size_t>(channels)) {
    for (const std::size_t c : {std::size_t{2}, std::size_t{1}, std::size_t{0}})
      bytes += static_cast<char>(values[i + c]);
    if (channels == 4) bytes += static_cast<char>(values[i + 3]);
  }
  write_bytes(path, bytes);
}

/// Writes a 24-bit BMP; `values` are R, G, B, top left first.
inline void write_bmp(const std::filesystem::path& path, int width, int height, const std::vector<int>& values) {
  const int row_bytes = (3 * width + 3) / 4 * 4;
  std::string bytes = "BM";
  for (const int field : {54 + row_bytes * height, 0, 54, 40, width, height})
    append_little(bytes, static_cast<std::uint32_t>(field), 4);
  append_little(bytes, 1, 2);
  append_little(bytes, 24, 2);
  for (const int field : {0, row_bytes * height, 2835, 2835, 0, 0})
    append_little(bytes, static_cast<std::uint32_t>(field), 4);
  for (int y = height - 1; y >= 0; --y) {
    const std::size_t begin = bytes.size();
    for (int x = 0; x < width; ++x)
      for (int c = 2; c >= 0; --c)
        bytes += static_cast<char>(values[static_cast<std::size_t>((y * width + x) * 3 + c)]);
    bytes.resize(begin + static_cast<std::size_t>(row_bytes));
  }
  write_bytes(path, bytes);
}

/// Writes an uncompressed Radiance HDR file; `values` are integers below 256 as R, G, B, top left first.
inline void write_hdr(const std::filesystem::path& path, int width, int height, const std::vector<int>& values) {
  std::string bytes =
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " + std::to_string(width) + "\n";
  for (std::size_t i = 0; i < values.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) bytes += static_cast<char>(values[i + c]);
    bytes += static_cast<char>(128 + 8);
  }
  write_bytes(path, bytes);
}

/// An entry of a TIFF directory: one number, or the file offset `value` of several.
struct TiffEntry {
  std::uint32_t tag, type, count, value;  ///< type 3: 16 bits, 4: 32 bits
};

/// Appends a TIFF directory. `bytes` is the file before it.
inline void append_tiff_directory(std::string& bytes, const std::vector<TiffEntry>& entries) {
  append_little(bytes, static_cast<std::uint32_t>(entries.size()), 2);
  for (const auto& [tag, type, count, value] : entries) {
    append_little(bytes, tag, 2);
    append_little(bytes, type, 2);
    append_little(bytes, count, 4);
    append_little(bytes, value, 4);
  }
  append_little(bytes, 0, 4);
}

/// Writes a TIFF with one strip of 8- or 16-bit gray or RGB samples, top left first.
inline void write_tiff(const std::filesystem::path& path, int width, int height, int channels, int bits,
                       const std::vector<int>& values) {
  std::string data;
  for (const int v : values) append_little(data, static_cast<std::uint32_t>(v), bits / 8);
  if (data.size() % 2 != 0) data += '\0';
  const auto samples = static_cast<std::uint32_t>(channels);
  const std::uint32_t bits_at = 8 + static_cast<std::uint32_t>(data.size()), directory_at = bits_at + 2 * samples;
  std::string bytes = "II";
  append_little(bytes, 42, 2);
  append_little(bytes, directory_at, 4);
  bytes += data;
  for (std::uint32_t c = 0; c < samples; ++c) append_little(bytes, static_cast<std::uint32_t>(bits), 2);
  const std::uint32_t size = static_cast<std::uint32_t>(values.size()) * static_cast<std::uint32_t>(bits / 8);
  append_tiff_directory(bytes, {{256, 4, 1, static_cast<std::uint32_t>(width)},
                                {257, 4, 1, static_cast<std::uint32_t>(height)},
                                {258, 3, samples, samples == 1 ? static_cast<std::uint32_t>(bits) : bits_at},
                                {259, 3, 1, 1},
                                {262, 3, 1, samples == 1 ? 1u : 2u},
                                {273, 4, 1, 8},
                                {277, 3, 1, samples},
                                {278, 4, 1, static_cast<std::uint32_t>(height)},
                                {279, 4, 1, size}});
  write_bytes(path, bytes);
}

/// Writes an 8-bit gray TIFF with one tile of 16 x 16 pixels. The image of `values`, at most 16 pixels wide, is in the
/// tile's top left corner. `claimed_width` and `claimed_height` are the tile size in the file's directory.
inline void write_tiled_tiff(const std::filesystem::path& path, int width, int height, const std::vector<int>& values,
                             std::uint32_t claimed_width = 16, std::uint32_t claimed_height = 16) {
  constexpr std::uint32_t kTileBytes = 256;
  std::string tile(kTileBytes, '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto columns = static_cast<std::size_t>(width);
    tile[i / columns * 16 + i % columns] = static_cast<char>(values[i]);
  }
  std::string bytes = "II";
  append_little(bytes, 42, 2);
  append_little(bytes, 8 + kTileBytes, 4);
  bytes += tile;
  append_tiff_directory(bytes, {{256, 4, 1, static_cast<std::uint32_t>(width)},
                                {257, 4, 1, static_cast<std::uint32_t>(height)},
                                {258, 3, 1, 8},
                                {259, 3, 1, 1},
                                {262, 3, 1, 1},
                                {277, 3, 1, 1},
                                {322, 4, 1, claimed_width},
                                {323, 4, 1, claimed_height},
                                {324, 4, 1, 8},
                                {325, 4, 1, kTileBytes}});
  write_bytes(path, bytes);
}

/// Writes a baseline JPEG of 8 x 8 pixels of one gray. Every quantization step is 1, so that the only coefficient, 8
/// times the difference from 128, is exact. It must be in [2^9, 2^10 - 1]: one code for the category and 10 bits.
inline void write_jpeg(const std::filesystem::path& path, int gray) {
  std::string bytes{'\xff', '\xd8', '\xff', '\xdb', 0, 67, 0};
  bytes.append(64, 1);
  for (const int b : {0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0}) bytes += static_cast<char>(b);
  for (const int table : {0x00, 0x10}) {
    for (const int b : {0xff, 0xc4, 0, 20, table, 1}) bytes += static_cast<char>(b);
    bytes.append(15, 0);
    bytes += static_cast<char>(table == 0 ? 10 : 0);
  }
  for (const int b : {0xff, 0xda, 0, 8, 1, 1, 0x00, 0, 63, 0}) bytes += static_cast<char>(b);
  const auto coefficient = static_cast<std::uint32_t>(8 * (gray - 128));
  const std::uint32_t bits = coefficient << 5 | 0xfu;  // 0, ten bits, 0, then ones up to the end of the byte
  bytes += static_cast<char>(bits >> 8 & 0x7fu);
  bytes += static_cast<char>(bits & 0xffu);
  bytes += "\xff\xd9";
  write_bytes(path, bytes);
}

/// Writes numbers of any number of bits, lowest bit first.
class BitWriter {
 public:
  void put(std::uint32_t value, int bits) {
    for (int i = 0; i < bits; ++i, ++count_) {
      if (count_ % 8 == 0) bytes_ += '\0';
      if (value >> i & 1u) bytes_.back() = static_cast<char>(bytes_.back() | 1 << count_ % 8);
    }
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  int count_ = 0;
};

/// A lossless WebP file (RFC 9649). `values` are R, G, B, A, top left first, with at most two values per channel. These
/// have prefix codes of one bit.
inline std::string webp_bytes(int width, int height, const std::vector<int>& values, bool has_alpha = true) {
  BitWriter bits;
  bits.put(0x2f, 8);
  bits.put(static_cast<std::uint32_t>(width - 1), 14);
  bits.put(static_cast<std::uint32_t>(height - 1), 14);
  bits.put(has_alpha ? 1 : 0, 1);
  bits.put(0, 3 + 3);  // version; no transform, no color cache, one group of prefix codes
  constexpr std::size_t kOrder[] = {1, 0, 2, 3};
  std::vector<int> used[4];
  for (const std::size_t channel : kOrder) {
    for (std::size_t i = channel; i < values.size(); i += 4) used[channel].push_back(values[i]);
    std::vector<int>& symbols = used[channel];
    std::sort(symbols.begin(), symbols.end());
    symbols.erase(std::unique(symbols.begin(), symbols.end()), symbols.end());
    bits.put(1, 1);
    bits.put(static_cast<std::uint32_t>(symbols.size()) - 1, 1);
    bits.put(1, 1);
    for (const int symbol : symbols) bits.put(static_cast<std::uint32_t>(symbol), 8);
  }
  bits.put(1, 4);  // one distance: 0
  for (std::size_t i = 0; i < values.size(); i += 4)
    for (const std::size_t channel : kOrder)
      if (used[channel].size() == 2) bits.put(values[i + channel] == used[channel][1] ? 1 : 0, 1);
  const std::string& data = bits.bytes();
  const auto size = static_cast<std::uint32_t>(data.size()), padding = size % 2;
  std::string bytes = "RIFF";
  append_little(bytes, 4 + 8 + size + padding, 4);
  bytes += "WEBPVP8L";
  append_little(bytes, size, 4);
  return bytes + data + std::string(padding, '\0');
}

}  // namespace sheaf

// Uncompressed TIFF files with any kind of samples.
#pragma once

#include "tests/support/files/image_files.h"

#include <string>
#include <vector>

namespace sheaf::test {

struct TiffSample {
  std::uint32_t width = 1, height = 1;
  std::uint32_t bits = 8, samples = 1;
  std::uint32_t format = 1;       ///< SampleFormat: 1 unsigned, 2 signed, 3 float
  std::uint32_t photometric = 1;  ///< 0 white is zero, 1 black is zero, 2 RGB, 3 palette, 5 CMYK
  bool is_separate = false;       ///< one strip per plane
  std::vector<std::uint32_t> extra_samples{};
  std::vector<std::uint32_t> palette{};  ///< red, then green, then blue, of 16 bits
};

/// `strips`: the bytes of one strip, or of one per plane, of equal length, in little-endian order.
inline std::string tiff_file(const TiffSample& sample, const std::string& strips) {
  std::string bytes = "II*" + std::string(5, '\0') + strips;
  const auto append_all = [&](const std::vector<std::uint32_t>& values, int size) {
    if (bytes.size() % 2 != 0) bytes += '\0';
    const auto at = static_cast<std::uint32_t>(bytes.size());
    for (const std::uint32_t value : values) append_little(bytes, value, size);
    return at;
  };
  std::vector<TiffEntry> entries;
  /// Several values are stored before the directory, unless they fit into the entry.
  const auto add = [&](std::uint32_t tag, std::uint32_t type, const std::vector<std::uint32_t>& values) {
    const auto count = static_cast<std::uint32_t>(values.size());
    const bool fits = count == 1 || (type == 3 && count == 2);
    const std::uint32_t value = count == 1 ? values[0]
                                : fits     ? values[0] | values[1] << 16
                                           : append_all(values, type == 3 ? 2 : 4);
    entries.push_back({tag, type, count, value});
  };
  const std::uint32_t planes = sample.is_separate ? sample.samples : 1;
  const std::uint32_t plane_bytes = static_cast<std::uint32_t>(strips.size()) / planes;
  std::vector<std::uint32_t> offsets;
  for (std::uint32_t plane = 0; plane < planes; ++plane) offsets.push_back(8 + plane * plane_bytes);
  add(256, 4, {sample.width});
  add(257, 4, {sample.height});
  add(258, 3, std::vector<std::uint32_t>(sample.samples, sample.bits));
  add(259, 3, {1});
  add(262, 3, {sample.photometric});
  add(273, 4, offsets);
  add(277, 3, {sample.samples});
  add(278, 4, {sample.height});
  add(279, 4, std::vector<std::uint32_t>(planes, plane_bytes));
  add(284, 3, {sample.is_separate ? 2u : 1u});
  if (!sample.palette.empty()) add(320, 3, sample.palette);
  if (!sample.extra_samples.empty()) add(338, 3, sample.extra_samples);
  add(339, 3, std::vector<std::uint32_t>(sample.samples, sample.format));
  if (bytes.size() % 2 != 0) bytes += '\0';
  const auto at = static_cast<std::uint32_t>(bytes.size());
  for (int i = 0; i < 4; ++i) bytes[static_cast<std::size_t>(4 + i)] = static_cast<char>(at >> (8 * i) & 0xffu);
  append_tiff_directory(bytes, entries);
  return bytes;
}

}  // namespace sheaf::test

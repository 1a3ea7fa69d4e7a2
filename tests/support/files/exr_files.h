// Writes OpenEXR files byte by byte, after the Academy Software Foundation's "OpenEXR File Layout", with data windows,
// chromaticities, channels and parts that write_exr() does not support.
#pragma once

#include "tests/support/files/image_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <string>
#include <vector>

namespace sheaf {

/// An uncompressed scan-line part of 32-bit floats.
struct ExrTestPart {
  std::string name;                                  ///< for multi-part files
  std::map<std::string, std::vector<float>> values;  ///< per channel, over the data window, top left first
  std::array<int, 4> window{};                       ///< data window: x and y of its first and last pixel
  std::array<int, 4> frame{};                        ///< display window
  std::vector<float> chromaticities;                 ///< x and y of red, green, blue, white; may be empty
};

namespace exr_files {

inline void append_int(std::string& out, int value) { append_little(out, static_cast<std::uint32_t>(value), 4); }
inline void append_float(std::string& out, float value) { append_little(out, std::bit_cast<std::uint32_t>(value), 4); }

inline void append_attribute(std::string& out, const std::string& name, const std::string& type,
                             const std::string& value) {
  out += name + '\0' + type + '\0';
  append_int(out, static_cast<int>(value.size()));
  out += value;
}

inline std::string header_of(const ExrTestPart& part, bool multi_part) {
  std::string channels, window, frame, chromaticities, one, center(8, '\0'), chunks, header;
  for (const auto& [name, values] : part.values) {
    channels += name + '\0';
    for (const int field : {2, 0, 1, 1}) append_int(channels, field);  // float, linear, every pixel
  }
  channels += '\0';
  for (const int side : part.window) append_int(window, side);
  for (const int side : part.frame) append_int(frame, side);
  for (const float c : part.chromaticities) append_float(chromaticities, c);
  append_float(one, 1);
  append_int(chunks, part.window[3] - part.window[1] + 1);
  append_attribute(header, "channels", "chlist", channels);
  if (!chromaticities.empty()) append_attribute(header, "chromaticities", "chromaticities", chromaticities);
  append_attribute(header, "compression", "compression", std::string(1, '\0'));
  append_attribute(header, "dataWindow", "box2i", window);
  append_attribute(header, "displayWindow", "box2i", frame);
  append_attribute(header, "lineOrder", "lineOrder", std::string(1, '\0'));
  append_attribute(header, "pixelAspectRatio", "float", one);
  append_attribute(header, "screenWindowCenter", "v2f", center);
  append_attribute(header, "screenWindowWidth", "float", one);
  if (multi_part) {
    append_attribute(header, "chunkCount", "int", chunks);
    append_attribute(header, "name", "string", part.name);
    append_attribute(header, "type", "string", "scanlineimage");
  }
  return header + '\0';
}

}  // namespace exr_files

/// Writes a single-part or multi-part file.
inline void write_exr_parts(const std::filesystem::path& path, const std::vector<ExrTestPart>& parts) {
  using namespace exr_files;
  const bool multi_part = parts.size() > 1;
  std::string file("\x76\x2f\x31\x01", 4);
  append_int(file, 2 | (multi_part ? 0x1000 : 0));
  std::size_t lines = 0;
  for (const ExrTestPart& part : parts) {
    file += header_of(part, multi_part);
    lines += static_cast<std::size_t>(part.window[3] - part.window[1] + 1);
  }
  if (multi_part) file += '\0';
  std::string offsets, chunks;
  const std::size_t data_at = file.size() + 8 * lines;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const ExrTestPart& part = parts[p];
    const auto width = static_cast<std::size_t>(part.window[2] - part.window[0] + 1);
    for (int y = part.window[1]; y <= part.window[3]; ++y) {
      append_little(offsets, static_cast<std::uint32_t>(data_at + chunks.size()), 4);
      append_little(offsets, 0, 4);
      if (multi_part) append_int(chunks, static_cast<int>(p));
      append_int(chunks, y);
      append_int(chunks, static_cast<int>(part.values.size() * width * sizeof(float)));
      for (const auto& [name, values] : part.values)
        for (std::size_t x = 0; x < width; ++x)
          append_float(chunks, values.at(static_cast<std::size_t>(y - part.window[1]) * width + x));
    }
  }
  write_bytes(path, file + offsets + chunks);
}

/// A part of `width` x `height` pixels with one constant value per channel.
inline ExrTestPart exr_part(int width, int height, const std::map<std::string, float>& values,
                            std::vector<float> chromaticities = {}, const std::string& name = {}) {
  ExrTestPart part;
  part.name = name;
  part.window = part.frame = {0, 0, width - 1, height - 1};
  part.chromaticities = std::move(chromaticities);
  for (const auto& [channel, value] : values)
    part.values[channel].assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value);
  return part;
}

}  // namespace sheaf

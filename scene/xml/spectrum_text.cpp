// Parses spectra and colors.
#include "scene/xml/spectrum_text.h"

#include "core/color/color.h"
#include "core/io/byte_order_mark.h"
#include "scene/xml/xml_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

namespace sheaf {

namespace {

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

Vec3f parse_hex(std::string_view text, const SourceLocation& where) {
  unsigned value = 0;
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data() + 1, end, value, 16);
  if (text.size() != 7 || result.ec != std::errc() || result.ptr != end)
    throw SceneError(where, fmt::format("color is {}, expected #rrggbb", in_quotes(text)));
  auto component = [&](unsigned shift) { return srgb_to_linear(static_cast<float>((value >> shift) & 255u) / 255.0f); };
  return {component(16), component(8), component(0)};
}

}  // namespace

SpectrumDescription parse_spectrum_text(std::string_view text, const SourceLocation& where) {
  if (text.find(':') == std::string_view::npos) {
    const std::size_t count = split_list(text).size();
    if (count == 3) return {SpectrumDescription::Rgb{parse_vec3(text, where, "spectrum").rounded()}};
    if (count > 1)
      throw SceneError(
          where, fmt::format("spectrum is {}, expected one number, three numbers of a color, or wavelength:value pairs",
                             in_quotes(text)));
    return SpectrumDescription::constant(parse_float(text, where, "spectrum"));
  }
  SpectrumDescription::Table table;
  for (std::string_view pair : split_list(text)) {
    const std::size_t colon = pair.find(':');
    if (colon == std::string_view::npos)
      throw SceneError(where, fmt::format("spectrum entry is {}, expected wavelength:value", in_quotes(pair)));
    table.wavelengths.push_back(parse_float(pair.substr(0, colon), where, "wavelength"));
    table.values.push_back(parse_float(pair.substr(colon + 1), where, "spectrum value"));
  }
  check_table(table, where);
  return {std::move(table)};
}

SpectrumDescription::Table read_spd(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMaxSize = std::uintmax_t{1} << 26;
  SourceLocation where{file.string(), 0};
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  std::ifstream stream(file);
  if (error || !stream) throw SceneError(where, "cannot be read");
  if (size > kMaxSize) throw SceneError(where, "spectrum file is larger than 64 MiB");
  // Read the pairs line by line
  SpectrumDescription::Table table;
  for (std::string line; std::getline(stream, line);) {
    if (++where.line == 1) remove_byte_order_mark(line, where.file.string());
    const auto parts = split_list(std::string_view(line).substr(0, line.find('#')));
    if (parts.empty()) continue;
    if (parts.size() != 2) throw SceneError(where, "expected a wavelength and a value, found " + in_quotes(line));
    table.wavelengths.push_back(parse_float(parts[0], where, "wavelength"));
    table.values.push_back(parse_float(parts[1], where, "spectrum value"));
    const std::size_t n = table.wavelengths.size();
    if (n > 1 && !(table.wavelengths[n - 1] > table.wavelengths[n - 2]))
      throw SceneError(where, "wavelengths must increase");
  }
  check_table(table, SourceLocation{where.file, 0});
  return table;
}

Vec3f parse_srgb(std::string_view text, const SourceLocation& where) {
  const std::string_view color = trim(text);
  if (color.starts_with('#')) return parse_hex(color, where);
  const Vec3f v = parse_vec3(color, where, "sRGB color").rounded();
  for (float c : {v.x, v.y, v.z})
    if (!(c >= 0 && c <= 1))
      throw SceneError(where, fmt::format("sRGB color is {}, expected values in [0, 1]", in_quotes(text)));
  return srgb_to_linear(v);
}

Vec3f parse_rgb(std::string_view text, const SourceLocation& where) {
  const std::string_view color = trim(text);
  return color.starts_with('#') ? parse_hex(color, where) : parse_vec3(color, where, "color").rounded();
}

}  // namespace sheaf

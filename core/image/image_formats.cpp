// The table of image formats, and the detection of a file's format.
#include "core/image/image_formats.h"

#include "core/image/formats/bmp.h"
#include "core/image/formats/jpeg.h"
#include "core/image/formats/png.h"
#include "core/image/formats/pnm.h"
#include "core/image/formats/radiance.h"
#include "core/image/formats/tga.h"
#include "core/image/formats/tiff.h"
#include "core/image/formats/webp.h"
#include "core/io/error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace sheaf {

namespace {

using namespace std::string_view_literals;

const std::vector<ImageFormat>& all_formats() {
  static const std::vector<ImageFormat> formats{
      {.name = "PNG",
       .magic = {"\x89PNG"sv},
       .is_written = true,
       .in_memory = true,
       .open = open_png,
       .library = "libpng",
       .version = png_version},
      {.name = "JPEG",
       .magic = {"\xff\xd8\xff"sv},
       .is_written = true,
       .in_memory = true,
       .open = open_jpeg,
       .library = "libjpeg-turbo",
       .version = jpeg_version},
      {.name = "TIFF",
       .magic = {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv},
       .is_written = true,
       .open = open_tiff,
       .library = "libtiff",
       .version = tiff_version},
      {.name = "WebP",
       .magic = {"WEBP"sv},
       .magic_at = 8,
       .in_memory = true,
       .min_counted_bytes = 1 << 15,  // files of a few bytes may hold large images of one color
       .open = open_webp,
       .library = "libwebp",
       .version = webp_version},
      {.name = "Radiance (.hdr)", .magic = {"#?"sv}, .open = open_radiance},
      {.name = "BMP", .magic = {"BM"sv}, .open = open_bmp},
      {.name = "PBM", .magic = {"P1"sv, "P4"sv}, .open = open_pnm},
      {.name = "PGM", .magic = {"P2"sv, "P5"sv}, .open = open_pnm},
      {.name = "PPM", .magic = {"P3"sv, "P6"sv}, .open = open_pnm},
      {.name = "PFM", .magic = {"Pf"sv, "PF"sv}, .open = open_pfm},
      {.name = "TGA", .extension = ".tga", .open = open_tga},
  };
  return formats;
}

bool matches(const ImageFormat& format, std::string_view head, std::string extension) {
  if (format.magic.empty()) {
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return extension == format.extension;
  }
  return std::any_of(format.magic.begin(), format.magic.end(),
                     [&](std::string_view magic) { return head.substr(format.magic_at).starts_with(magic); });
}

/// "PNG, JPEG or WebP": the formats that are read from the disk or from memory.
std::string list_formats(bool in_memory) {
  std::vector<std::string_view> names;
  if (!in_memory) names.emplace_back("OpenEXR");
  for (const ImageFormat& format : all_formats())
    if (format.in_memory || !in_memory) names.push_back(format.name);
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{} or {}", fmt::join(names, ", "), last);
}

}  // namespace

std::span<const ImageFormat> image_formats() { return all_formats(); }

const ImageFormat& find_image_format(ImageSource& source) {
  const bool in_memory = source.memory() != nullptr;
  std::array<unsigned char, 12> bytes{};
  source.read(0, bytes);
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const ImageFormat& format : all_formats())
    if ((format.in_memory || !in_memory) && matches(format, head, source.path().extension().string())) return format;
  throw SceneError({source.path().string(), 0}, fmt::format("cannot read the image: expected {}{}",
                                                            in_memory ? "" : "a file of ", list_formats(in_memory)));
}

}  // namespace sheaf

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
       .extensions = {".png"sv},
       .magic = {"\x89PNG"sv},
       .written = IntegerFormat::kPng,
       .in_memory = true,
       .open = open_png,
       .library = "libpng",
       .version = png_version},
      {.name = "JPEG",
       .extensions = {".jpg"sv, ".jpeg"sv},
       .magic = {"\xff\xd8\xff"sv},
       .written = IntegerFormat::kJpeg,
       .in_memory = true,
       .open = open_jpeg,
       .library = "libjpeg-turbo",
       .version = jpeg_version},
      {.name = "TIFF",
       .extensions = {".tif"sv, ".tiff"sv},
       .magic = {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv},
       .written = IntegerFormat::kTiff,
       .open = open_tiff,
       .library = "libtiff",
       .version = tiff_version},
      {.name = "WebP",
       .extensions = {".webp"sv},
       .magic = {"WEBP"sv},
       .magic_at = 8,
       .in_memory = true,
       .min_counted_bytes = 1 << 15,  // files of a few bytes may hold large images of one color
       .open = open_webp,
       .library = "libwebp",
       .version = webp_version},
      {.name = "Radiance HDR", .extensions = {".hdr"sv, ".pic"sv}, .magic = {"#?"sv}, .open = open_radiance},
      {.name = "BMP", .extensions = {".bmp"sv}, .magic = {"BM"sv}, .open = open_bmp},
      {.name = "PBM", .extensions = {".pbm"sv}, .magic = {"P1"sv, "P4"sv}, .open = open_pnm},
      {.name = "PGM", .extensions = {".pgm"sv}, .magic = {"P2"sv, "P5"sv}, .open = open_pnm},
      {.name = "PPM", .extensions = {".ppm"sv}, .magic = {"P3"sv, "P6"sv}, .open = open_pnm},
      {.name = "PFM", .extensions = {".pfm"sv}, .magic = {"Pf"sv, "PF"sv}, .open = open_pfm},
      {.name = "TGA", .extensions = {".tga"sv}, .open = open_tga},
  };
  return formats;
}

bool matches(const ImageFormat& format, std::string_view head, std::string extension) {
  if (format.magic.empty()) {
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return std::find(format.extensions.begin(), format.extensions.end(), extension) != format.extensions.end();
  }
  return std::any_of(format.magic.begin(), format.magic.end(),
                     [&](std::string_view magic) { return head.substr(format.magic_at).starts_with(magic); });
}

}  // namespace

std::span<const ImageFormat> image_formats() { return all_formats(); }

std::string list_image_formats(bool in_memory) {
  std::vector<std::string_view> names;
  if (!in_memory) names.emplace_back("OpenEXR");
  for (const ImageFormat& format : all_formats())
    if (format.in_memory || !in_memory) names.push_back(format.name);
  const std::string_view last = names.back();
  names.pop_back();
  return fmt::format("{} or {}", fmt::join(names, ", "), last);
}

const ImageFormat& find_image_format(ImageSource& source) {
  const bool in_memory = source.memory() != nullptr;
  std::array<unsigned char, 12> bytes{};
  source.read(0, bytes);
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const ImageFormat& format : all_formats())
    if ((format.in_memory || !in_memory) && matches(format, head, source.path().extension().string())) return format;
  throw SceneError({source.path().string(), 0},
                   fmt::format("cannot read the image: expected {}{}", in_memory ? "" : "a file of ",
                               list_image_formats(in_memory)));
}

}  // namespace sheaf

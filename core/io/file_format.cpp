// The table of known file formats, and their detection by magic numbers, structure and file extension.
#include "core/io/file_format.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// Number of bytes at the beginning of a file that are examined.
constexpr std::size_t kBeginning = 4096;

using namespace std::string_view_literals;

bool is_x3d(std::string_view bytes, std::uintmax_t) {
  const std::size_t first = std::min(bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf"), bytes.size());
  return bytes.substr(first).starts_with('<') && bytes.find("<X3D") != bytes.npos;
}
bool is_webp(std::string_view bytes, std::uintmax_t) {
  return bytes.starts_with("RIFF") && bytes.substr(8).starts_with("WEBP");
}

constexpr std::array kKnown = {
    KnownFormat{FileUse::kModel, "a USD scene", {"PXR-USDC"sv, "#usda"sv}, {".usd", ".usda", ".usdc", ".usdz"}},
    KnownFormat{FileUse::kModel, "a Blender file", {"BLENDER"sv}, {".blend"}},
    KnownFormat{FileUse::kModel, "an Alembic file", {"Ogawa"sv, "\x89HDF"sv}, {".abc"}},
    KnownFormat{FileUse::kModel, "a 3D Studio scene", {}, {".max"}},
    KnownFormat{FileUse::kModel, "a Maya scene", {"//Maya ASCII"sv}, {".ma", ".mb"}},
    KnownFormat{FileUse::kModel, "a Cinema 4D scene", {}, {".c4d"}},
    KnownFormat{FileUse::kModel, "a LightWave model", {}, {".lwo", ".lws"}},
    KnownFormat{FileUse::kModel, "an X3D scene", {"#VRML"sv, "#X3D"sv}, {".x3d", ".x3dv", ".wrl"}, is_x3d},
    KnownFormat{FileUse::kModel, "a 3MF model", {}, {".3mf"}},
    KnownFormat{FileUse::kModel, "a CAD model", {"ISO-10303-21"sv}, {".step", ".stp", ".iges", ".igs", ".skp", ".dxf"}},
    KnownFormat{FileUse::kImage, "an OpenEXR image", {"v/1\x01"sv}, {".exr"}},
    KnownFormat{FileUse::kImage, "a PNG image", {"\x89PNG"sv}, {".png"}},
    KnownFormat{FileUse::kImage, "a JPEG image", {"\xff\xd8\xff"sv}, {".jpg", ".jpeg"}},
    KnownFormat{FileUse::kImage, "a Radiance image", {"#?RADIANCE"sv, "#?RGBE"sv}, {".hdr", ".pic"}},
    KnownFormat{FileUse::kImage, "a TIFF image", {"II*\0"sv, "MM\0*"sv}, {".tif", ".tiff"}},
    KnownFormat{FileUse::kImage, "a GIF image", {"GIF8"sv}, {".gif"}},
    KnownFormat{FileUse::kImage, "a Photoshop image", {"8BPS"sv}, {".psd"}},
    KnownFormat{FileUse::kImage, "a DirectDraw surface", {"DDS "sv}, {".dds"}},
    KnownFormat{FileUse::kImage, "a TGA image", {}, {".tga"}},
    KnownFormat{FileUse::kImage, "a BMP image", {}, {".bmp"}},
    KnownFormat{FileUse::kImage, "a WebP image", {}, {".webp"}, is_webp},
    KnownFormat{FileUse::kImage, "an image", {}, {".pfm", ".ppm", ".pgm", ".pbm", ".heic", ".avif", ".jp2"}},
    KnownFormat{FileUse::kScenePart, "a NanoVDB file", {"NanoVDB"sv}, {".nvdb"}},
    KnownFormat{FileUse::kScenePart, "an OpenVDB file", {" BDV\0\0\0\0"sv}, {".vdb"}},
    KnownFormat{FileUse::kScenePart, "a Mitsuba volume", {"VOL\x03"sv}, {".vol"}},
    KnownFormat{FileUse::kScenePart, "a material library", {}, {".mtl"}},
    KnownFormat{FileUse::kScenePart, "a spectrum", {}, {".spd"}},
    KnownFormat{FileUse::kScenePart, "a measured material", {"tensor_file"sv}, {".bsdf", ".pbsdf"}},
    KnownFormat{FileUse::kScenePart, "a hair file", {"BINARY_HAIR"sv}, {".hair"}},
    KnownFormat{FileUse::kArchive, "a ZIP archive", {"PK\x03\x04"sv}, {".zip"}},
    KnownFormat{FileUse::kArchive, "an archive", {"7z\xbc\xaf"sv, "Rar!"sv}, {".7z", ".rar", ".tar", ".tgz"}},
    KnownFormat{FileUse::kArchive,
                "a compressed file",
                {"\x28\xb5\x2f\xfd"sv, "BZh"sv,
                 "\xfd"
                 "7zXZ"sv,
                 "\x1f\x8b"sv},
                {".gz", ".bz2", ".xz", ".zst"}},
};

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string read_beginning(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(kBeginning, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

/// The formats in their order of precedence.
std::vector<const KnownFormat*> all_formats(std::span<const KnownFormat> more) {
  std::vector<const KnownFormat*> all;
  for (const KnownFormat& known : more) all.push_back(&known);
  for (const KnownFormat& known : kKnown) all.push_back(&known);
  return all;
}

const KnownFormat* find_extension(const std::vector<const KnownFormat*>& formats, const std::string& extension) {
  if (extension.empty()) return nullptr;
  for (const KnownFormat* known : formats)
    if (std::find(known->extensions.begin(), known->extensions.end(), extension) != known->extensions.end())
      return known;
  return nullptr;
}

}  // namespace

std::vector<KnownFormat> scene_part_formats() {
  std::vector<KnownFormat> parts;
  for (const KnownFormat& known : kKnown)
    if (known.use == FileUse::kScenePart) parts.push_back(known);
  return parts;
}

FileFormat file_format(const fs::path& file, std::span<const KnownFormat> more) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) return {};
  if (size == 0) return {FileUse::kEmpty, "empty", true};
  const std::string bytes = read_beginning(file);
  if (bytes.empty()) return {};
  const std::vector<const KnownFormat*> formats = all_formats(more);
  const KnownFormat* const named = find_extension(formats, lower(file.extension().string()));
  for (const KnownFormat* known : formats)
    for (const std::string_view beginning : known->beginnings) {
      if (beginning.empty() || !bytes.starts_with(beginning)) continue;
      // Other formats that are archives inside, such as USDZ and 3MF, are named by their extension.
      if (known->use == FileUse::kArchive && named != nullptr) return {named->use, named->name, true};
      return {known->use, known->name, true};
    }
  for (const KnownFormat* known : formats)
    if (known->matches != nullptr && known->matches(bytes, size)) return {known->use, known->name, true};
  const std::size_t first = std::min(bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf"), bytes.size());
  if (named == nullptr || bytes.substr(first).starts_with('<')) return {};
  return {named->use, named->name, false};
}

}  // namespace sheaf

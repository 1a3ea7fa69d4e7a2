// The table of known file formats, and their detection by magic numbers, structure and file extension.
#include "core/io/file_format.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <string_view>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// Number of bytes at the beginning of a file that are examined.
constexpr std::size_t kBeginning = 4096;

struct Known {
  FileUse use;
  const char* name;
  std::array<std::string_view, 4> beginnings;  ///< unused entries are empty
  std::array<std::string_view, 7> extensions;  ///< likewise
};

using namespace std::string_view_literals;

constexpr std::array kKnown = {
    Known{FileUse::kModel, "a glTF model", {"glTF"sv}, {".glb", ".gltf"}},
    Known{FileUse::kModel, "a USD scene", {"PXR-USDC"sv, "#usda"sv}, {".usd", ".usda", ".usdc", ".usdz"}},
    Known{FileUse::kModel, "an STL model", {}, {".stl"}},
    Known{FileUse::kModel, "an FBX model", {"Kaydara FBX Binary"sv, "; FBX"sv}, {".fbx"}},
    Known{FileUse::kModel, "a COLLADA model", {}, {".dae"}},
    Known{FileUse::kModel, "a Blender file", {"BLENDER"sv}, {".blend"}},
    Known{FileUse::kModel, "an Alembic file", {"Ogawa"sv, "\x89HDF"sv}, {".abc"}},
    Known{FileUse::kModel, "an OFF model", {"OFF\n"sv, "OFF\r"sv}, {".off"}},
    Known{FileUse::kModel, "a 3D Studio model", {}, {".3ds", ".max"}},
    Known{FileUse::kModel, "a Maya scene", {"//Maya ASCII"sv}, {".ma", ".mb"}},
    Known{FileUse::kModel, "a Cinema 4D scene", {}, {".c4d"}},
    Known{FileUse::kModel, "a LightWave model", {}, {".lwo", ".lws"}},
    Known{FileUse::kModel, "an X3D scene", {"#VRML"sv, "#X3D"sv}, {".x3d", ".x3dv", ".wrl"}},
    Known{FileUse::kModel, "a 3MF model", {}, {".3mf"}},
    Known{FileUse::kModel, "a CAD model", {"ISO-10303-21"sv}, {".step", ".stp", ".iges", ".igs", ".skp", ".dxf"}},
    Known{FileUse::kVolume, "an OpenVDB file", {" BDV\0\0\0\0"sv}, {".vdb"}},
    Known{FileUse::kImage, "an OpenEXR image", {"v/1\x01"sv}, {".exr"}},
    Known{FileUse::kImage, "a PNG image", {"\x89PNG"sv}, {".png"}},
    Known{FileUse::kImage, "a JPEG image", {"\xff\xd8\xff"sv}, {".jpg", ".jpeg"}},
    Known{FileUse::kImage, "a Radiance image", {"#?RADIANCE"sv, "#?RGBE"sv}, {".hdr", ".pic"}},
    Known{FileUse::kImage, "a TIFF image", {"II*\0"sv, "MM\0*"sv}, {".tif", ".tiff"}},
    Known{FileUse::kImage, "a GIF image", {"GIF8"sv}, {".gif"}},
    Known{FileUse::kImage, "a Photoshop image", {"8BPS"sv}, {".psd"}},
    Known{FileUse::kImage, "a DirectDraw surface", {"DDS "sv}, {".dds"}},
    Known{FileUse::kImage, "a TGA image", {}, {".tga"}},
    Known{FileUse::kImage, "a BMP image", {}, {".bmp"}},
    Known{FileUse::kImage, "a WebP image", {}, {".webp"}},
    Known{FileUse::kImage, "an image", {}, {".pfm", ".ppm", ".pgm", ".pbm", ".heic", ".avif", ".jp2"}},
    Known{FileUse::kScenePart, "a NanoVDB file", {"NanoVDB"sv}, {".nvdb"}},
    Known{FileUse::kScenePart, "a Mitsuba volume", {"VOL\x03"sv}, {".vol"}},
    Known{FileUse::kScenePart, "a material library", {}, {".mtl"}},
    Known{FileUse::kScenePart, "a spectrum", {}, {".spd"}},
    Known{FileUse::kScenePart, "a measured material", {"tensor_file"sv}, {".bsdf"}},
    Known{FileUse::kScenePart, "a hair file", {"BINARY_HAIR"sv}, {".hair"}},
    Known{FileUse::kArchive, "a ZIP archive", {"PK\x03\x04"sv}, {".zip"}},
    Known{FileUse::kArchive, "an archive", {"7z\xbc\xaf"sv, "Rar!"sv}, {".7z", ".rar", ".tar", ".tgz"}},
    Known{FileUse::kArchive,
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

const Known* find_extension(const std::string& extension) {
  if (extension.empty()) return nullptr;
  for (const Known& known : kKnown)
    if (std::find(known.extensions.begin(), known.extensions.end(), extension) != known.extensions.end()) return &known;
  return nullptr;
}

/// Detects formats that have no magic number. Returns their file extension, or null.
const char* find_by_structure(std::string_view bytes, std::uintmax_t size) {
  const auto has = [&](std::string_view text) { return bytes.find(text) != bytes.npos; };
  const std::size_t first = std::min(bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf"), bytes.size());
  if (bytes.substr(first).starts_with('<')) return has("<COLLADA") ? ".dae" : has("<X3D") ? ".x3d" : nullptr;
  if (bytes.substr(first).starts_with('{')) return has("\"asset\"") || has("\"meshes\"") ? ".gltf" : nullptr;
  if (bytes.starts_with("solid") && has("facet normal")) return ".stl";
  if (bytes.starts_with("RIFF") && bytes.substr(8).starts_with("WEBP")) return ".webp";
  // The header of a binary STL file has 84 bytes and ends with the number of triangles, of 50 bytes each.
  constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;
  if (bytes.size() < kStlHeader) return nullptr;
  std::uint64_t triangles = 0;
  for (std::size_t i = 4; i-- > 0;) triangles = triangles << 8 | static_cast<unsigned char>(bytes[80 + i]);
  return triangles > 0 && size == kStlHeader + kStlTriangle * triangles ? ".stl" : nullptr;
}

}  // namespace

FileFormat file_format(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {};
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) return {};
  if (size == 0) return {FileUse::kEmpty, "empty", true};
  const std::string bytes = read_beginning(file);
  if (bytes.empty()) return {};
  const std::string extension = lower(file.extension().string());
  const Known* const named = find_extension(extension);
  for (const Known& known : kKnown)
    for (const std::string_view beginning : known.beginnings) {
      if (beginning.empty() || !bytes.starts_with(beginning)) continue;
      // Other formats that are archives inside, such as USDZ and 3MF, are named by their extension.
      if (known.use == FileUse::kArchive && named != nullptr) return {named->use, named->name, true};
      return {known.use, known.name, true};
    }
  if (const char* found = find_by_structure(bytes, size)) {
    const Known* const known = find_extension(found);
    return {known->use, known->name, true};
  }
  const std::size_t first = std::min(bytes.find_first_not_of(" \t\r\n\xef\xbb\xbf"), bytes.size());
  if (named == nullptr || bytes.substr(first).starts_with('<')) return {};
  return {named->use, named->name, false};
}

}  // namespace sheaf

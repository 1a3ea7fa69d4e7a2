#include "scene/formats/model_formats.h"

#include "scene/formats/serialized.h"
#include "scene/formats/stl.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>

namespace sheaf {

namespace {

using namespace std::string_view_literals;

/// The first word that is not in a comment.
std::string_view first_word(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r\n";
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kSpaces), text.size()));
    if (!text.starts_with('#')) return text.substr(0, text.find_first_of(kSpaces));
    text.remove_prefix(std::min(text.find('\n'), text.size()));
  }
}

/// Whether the text is XML or JSON and contains one of the strings.
bool has_document(std::string_view text, char first, std::span<const std::string_view> contents) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t\r\n\xef\xbb\xbf"), text.size());
  return text.substr(begin).starts_with(first) &&
         std::any_of(contents.begin(), contents.end(), [&](auto content) { return text.find(content) != text.npos; });
}

bool is_collada(std::string_view text) { return has_document(text, '<', std::array{"<COLLADA"sv}); }
bool is_gltf_text(std::string_view text, std::uintmax_t) {
  return has_document(text, '{', std::array{"\"asset\""sv, "\"meshes\""sv});
}

bool is_stl(std::string_view bytes, std::uintmax_t size) {
  if (bytes.starts_with("solid") && bytes.find("facet normal") != bytes.npos) return true;
  // The header of a binary file has 84 bytes and ends with the number of triangles, of 50 bytes each.
  constexpr std::size_t kHeader = 84, kTriangle = 50;
  if (bytes.size() < kHeader) return false;
  std::uint64_t triangles = 0;
  for (std::size_t i = 4; i-- > 0;) triangles = triangles << 8 | static_cast<unsigned char>(bytes[80 + i]);
  return triangles > 0 && size == kHeader + kTriangle * triangles;
}

bool begins_obj(std::string_view text) {
  constexpr std::array kWords{"v"sv, "vt"sv, "vn"sv, "f"sv, "o"sv, "g"sv, "s"sv, "l"sv, "mtllib"sv, "usemtl"sv};
  return std::find(kWords.begin(), kWords.end(), first_word(text)) != kWords.end();
}

constexpr FileUse kModel = FileUse::kModel;

const std::array kFormats = {
    ModelFormat{.key = "gltf",
                .known = {kModel, "a glTF model", {}, {".gltf"}, is_gltf_text},
                .begins = [](std::string_view text) { return first_word(text).starts_with('{'); },
                .documentation = "gltf.md#glTF"},
    ModelFormat{.key = "glb", .known = {kModel, "a glTF model", {"glTF"}, {".glb"}}, .documentation = "gltf.md#glTF"},
    ModelFormat{.key = "dae",
                .known = {kModel, "a COLLADA model", {}, {".dae"}, [](auto text, auto) { return is_collada(text); }},
                .is_imported = true,
                .begins = is_collada,
                .documentation = "models.md#Imported models"},
    ModelFormat{.key = "fbx",
                .known = {kModel, "an FBX model", {"Kaydara FBX Binary", "; FBX"}, {".fbx"}},
                .is_imported = true,
                .begins = [](std::string_view text) { return first_word(text) == ";"; },
                .documentation = "models.md#Imported models"},
    ModelFormat{.key = "3ds",
                .known = {kModel, "a 3D Studio model", {}, {".3ds"}},
                .is_imported = true,
                .begins = [](std::string_view bytes) { return bytes.starts_with("MM"); },
                .documentation = "models.md#Imported models"},
    ModelFormat{.key = "off",
                .known = {kModel, "an OFF model", {"OFF\n", "OFF\r"}, {".off"}},
                .is_imported = true,
                .begins = [](std::string_view text) { return first_word(text).ends_with("OFF"); },
                .documentation = "models.md#Imported models"},
    ModelFormat{.key = "obj",
                .known = {kModel, "an OBJ model", {}, {".obj"}},
                .read = [](const MeshFileShape& s) { return read_obj(s.file, s.flip_tex_coords, s.bad_faces); },
                .begins = begins_obj,
                .documentation = "models.md#Models"},
    ModelFormat{.key = "ply",
                .known = {kModel, "a PLY model", {"ply\n", "ply\r"}, {".ply"}},
                .read = [](const MeshFileShape& s) { return read_ply(s.file, s.flip_tex_coords, s.bad_faces); },
                .begins = [](std::string_view text) { return first_word(text) == "ply"; },
                .documentation = "models.md#Models"},
    ModelFormat{.key = "stl",
                .known = {kModel, "an STL model", {}, {".stl"}, is_stl},
                .read = [](const MeshFileShape& s) { return read_stl(s.file); },
                .begins = [](std::string_view text) { return first_word(text) == "solid"; },
                .documentation = "models.md#Models"},
    ModelFormat{.key = "serialized",
                .known = {kModel, "a serialized mesh", {"\x1c\x04"}, {".serialized"}},
                .read = [](const MeshFileShape& s) { return read_serialized(s.file, s.shape_index, s.bad_faces); },
                .is_compressed = true,
                .documentation = "models.md#Models"},
};

/// The extensions of the formats that `is_wanted` selects.
template <class IsWanted> std::string extensions_of(IsWanted is_wanted) {
  std::string all;
  for (const ModelFormat& format : kFormats)
    for (const std::string_view extension : format.known.extensions)
      if (is_wanted(format) && !extension.empty()) all += (all.empty() ? "" : ", ") + std::string(extension);
  return all;
}

}  // namespace

std::span<const ModelFormat> model_formats() { return kFormats; }

const ModelFormat* find_model_format(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension.empty()) return nullptr;
  for (const ModelFormat& format : kFormats)
    if (std::find(format.known.extensions.begin(), format.known.extensions.end(), extension) !=
        format.known.extensions.end())
      return &format;
  return nullptr;
}

const ModelFormat& mesh_format(std::string_view key) {
  for (const ModelFormat& format : kFormats)
    if (format.key == key && format.read != nullptr) return format;
  throw Error(ExitCode::kRuntime, fmt::format("unknown format of meshes '{}'", key));
}

const ModelFormat* detect_model_format(std::string_view bytes) {
  for (const ModelFormat& format : kFormats) {
    for (const std::string_view beginning : format.known.beginnings)
      if (!beginning.empty() && bytes.starts_with(beginning)) return &format;
    if (format.begins != nullptr && format.begins(bytes)) return &format;
  }
  return nullptr;
}

FileFormat file_or_model_format(const std::filesystem::path& file) {
  std::vector<KnownFormat> known;
  for (const ModelFormat& format : kFormats) known.push_back(format.known);
  return file_format(file, known);
}

std::string model_extensions() {
  return extensions_of([](const ModelFormat&) { return true; });
}

std::string scene_model_extensions() {
  return extensions_of([](const ModelFormat& format) { return format.read == nullptr; });
}

}  // namespace sheaf

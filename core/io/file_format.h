// Detection of file formats by content and file extension, for messages about unsupported files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// The purpose of a file format.
enum class FileUse {
  kUnknown,    ///< neither content nor extension is known; includes scenes and models that Sheaf reads
  kEmpty,      ///< no bytes
  kModel,      ///< model or scene of another program
  kImage,      ///< image, supported or not
  kScenePart,  ///< asset of a scene, not a scene itself
  kArchive     ///< compressed file or archive
};

/// The format of a file.
struct FileFormat {
  FileUse use = FileUse::kUnknown;
  std::string name;         ///< for messages, with its article: "a glTF model"
  bool by_content = false;  ///< recognized by its content, not only by its extension
};

/// How to recognize a format.
struct KnownFormat {
  FileUse use;
  const char* name;                            ///< as in FileFormat
  std::array<std::string_view, 4> beginnings;  ///< magic numbers; unused entries are empty
  std::array<std::string_view, 7> extensions;  ///< likewise
  /// For formats without a magic number: whether a file of `size` bytes that starts with these bytes has the format.
  bool (*matches)(std::string_view bytes, std::uintmax_t size) = nullptr;
};

/// The formats of assets that have neither a table of their own nor several versions: FileUse::kScenePart.
std::vector<KnownFormat> scene_part_formats();

/// Checks the first bytes, then the file extension: for the formats in `more`, and for those of files that Sheaf does
/// not read as models. Returns kUnknown if `file` is not a regular file or cannot be read.
FileFormat file_format(const std::filesystem::path& file, std::span<const KnownFormat> more = {});

}  // namespace sheaf

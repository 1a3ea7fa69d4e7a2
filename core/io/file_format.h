// Detection of file formats by content and file extension, for messages about unsupported files.
#pragma once

#include <filesystem>
#include <string>

namespace sheaf {

/// The purpose of a file format.
enum class FileUse {
  kUnknown,    ///< neither content nor extension is known; includes scenes and models that Sheaf reads
  kEmpty,      ///< no bytes
  kModel,      ///< model or scene of another program
  kVolume,     ///< density grid of another program
  kImage,      ///< image, supported or not
  kScenePart,  ///< asset of a scene, not a scene itself
  kArchive     ///< compressed file or archive
};

/// The format of a file.
struct FileFormat {
  FileUse use = FileUse::kUnknown;
  std::string name;         ///< for messages, with its article: "a glTF model"
  bool by_content = false;  ///< recognised by its content, not only by its extension
};

/// Checks the first bytes, then the file extension. Returns kUnknown if `file` is not a regular file or cannot be read.
FileFormat file_format(const std::filesystem::path& file);

}  // namespace sheaf

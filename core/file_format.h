// What a file is, by how it begins and by its name: for messages about files of formats that are not read.
#pragma once

#include <filesystem>
#include <string>

namespace sheaf {

/// What files of a format are for.
enum class FileUse {
  kUnknown,    ///< neither content nor name is known; scenes and models of Sheaf's own formats among them
  kEmpty,      ///< no bytes
  kModel,      ///< a model or a scene of another program
  kVolume,     ///< a grid of another program
  kPicture,    ///< a picture, whether it is read or not
  kScenePart,  ///< something that scenes name, but no scene
  kArchive     ///< compressed
};

/// The format of a file.
struct FileFormat {
  FileUse use = FileUse::kUnknown;
  std::string name;         ///< for messages, with its article: "a glTF model"
  bool by_content = false;  ///< told by how the file begins, not by its name alone
};

/// Looks at the first bytes, then at the extension. kUnknown for what is no regular file or cannot be read.
FileFormat file_format(const std::filesystem::path& file);

}  // namespace sheaf

#include "tools/picture_files.h"

#include "core/error.h"

#include <cctype>

namespace sheaf {

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

void check_picture_name(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  if (extension != ".exr" && extension != ".png")
    throw Error(ExitCode::kUsage, "the name of the picture '" + path.string() + "' must end in .exr or .png");
}

}  // namespace sheaf

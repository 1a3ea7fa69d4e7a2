#include "tools/cli/build_details.h"

#include "core/image/display_view.h"
#include "core/image/image_formats.h"
#include "core/io/module.h"
#include "scene/formats/model_import.h"
#include "tools/cli/libraries.h"

#include <fmt/format.h>

namespace sheaf {

namespace {

/// The name of a shipped file, and its place.
std::string placed(const std::string& name) {
  const std::filesystem::path file = shipped_file(name);
  return fmt::format("{} ({})", name, file.empty() ? "missing" : file.string());
}

}  // namespace

std::string build_details() {
  std::string libraries, written, read;
  for (const ImageFormat& format : image_formats()) {
    if (!format.library.empty()) libraries += fmt::format("{} {}, ", format.library, format.version());
    (format.written ? written : read) += fmt::format(", {}", format.name);
  }
  return fmt::format(
      "libraries: {}{}\n"
      "images: OpenEXR{}; read only: {}\n"
      "OpenColorIO by {}\n"
      "FBX, COLLADA, 3D Studio and OFF models by {}\n",
      libraries, kLibraries, written, read.substr(2), placed(kColorLibrary), placed(kModelImporter));
}

}  // namespace sheaf

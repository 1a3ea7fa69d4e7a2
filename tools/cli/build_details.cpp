#include "tools/cli/build_details.h"

#include "core/image/display_view.h"
#include "core/image/image_library.h"
#include "core/image/jpeg.h"
#include "core/image/png.h"
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
  return fmt::format(
      "libraries: libpng {}, libjpeg-turbo {}, {}\n"
      "images: OpenEXR, PNG, JPEG\n"
      "images by {}: TIFF; read only: WebP, Radiance (.hdr), BMP, PFM, PGM, PPM, TGA\n"
      "OpenColorIO by {}\n"
      "FBX, COLLADA, 3D Studio and OFF models by {}\n",
      png_version(), jpeg_version(), kLibraries, placed(kImageLibrary), placed(kColorLibrary), placed(kModelImporter));
}

}  // namespace sheaf

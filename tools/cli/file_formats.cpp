#include "tools/cli/file_formats.h"

#include "core/image/image_formats.h"
#include "core/io/file_format.h"
#include "scene/dialects/read_scene.h"
#include "scene/formats/model_formats.h"
#include "scene/formats/model_import.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sheaf {

namespace {

/// "glTF model" of "a glTF model".
std::string without_article(std::string_view name) { return std::string(name.substr(name.find(' ') + 1)); }

/// The extensions without unused entries.
template <class Extensions> std::vector<std::string> used(const Extensions& extensions) {
  std::vector<std::string> used;
  for (const std::string_view extension : extensions)
    if (!extension.empty()) used.emplace_back(extension);
  return used;
}

}  // namespace

std::vector<ListedFormat> file_formats() {
  std::vector<ListedFormat> formats;
  for (const SceneDialect& dialect : scene_dialects())
    formats.push_back({"scene", dialect.name, used(dialect.extensions)});
  for (const ModelFormat& model : model_formats()) {
    ListedFormat& format =
        formats.emplace_back(ListedFormat{"model", without_article(model.known.name), used(model.known.extensions)});
    if (!model.is_imported) continue;
    format.reader = kModelImporter;
    format.is_available = can_import_models();
  }
  formats.push_back({"image", "OpenEXR", {".exr"}, true, "OpenEXR"});
  for (const ImageFormat& image : image_formats())
    formats.push_back({"image", std::string(image.name), used(image.extensions), image.written.has_value(),
                       std::string(image.library)});
  for (const KnownFormat& part : scene_part_formats())
    formats.push_back({"asset", without_article(part.name), used(part.extensions)});
  return formats;
}

std::string describe(const std::vector<ListedFormat>& formats) {
  std::string text;
  for (const ListedFormat& format : formats)
    text += fmt::format("{:<12}{} ({}){}{}{}\n", format.kind, format.name, fmt::join(format.extensions, ", "),
                        format.is_written ? ", also written" : "",
                        format.reader.empty() ? "" : fmt::format(", by {}", format.reader),
                        format.is_available ? "" : " (missing)");
  return text;
}

}  // namespace sheaf

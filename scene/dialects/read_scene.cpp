// Chooses the dialect of a scene file by its content.
#include "scene/dialects/read_scene.h"

#include "scene/dialects/dialects.h"
#include "scene/dialects/obj_materials.h"
#include "scene/dialects/read_spectrum.h"
#include "scene/dialects/read_texture.h"

namespace sheaf {

namespace {

/// Positive for Mitsuba, negative for Nori.
int dialect_score(const XmlElement& root) {
  int score = root.find_attribute("version") != nullptr ? 2 : -1;
  for (const XmlElement& child : root.children) {
    if (child.name == "sensor" || child.name == "shape" || child.name == "texture") score += 2;
    if (child.name == "camera" || child.name == "mesh" || child.name == "test") score -= 2;
    if (child.name == "ref" || child.find_attribute("id") != nullptr) score += 1;
  }
  return score;
}

}  // namespace

MaterialId add_material(ReadContext& context, MaterialDescription material) {
  context.description.materials.push_back(std::move(material));
  return static_cast<MaterialId>(context.description.materials.size() - 1);
}

void check_frame(int width, int height, const SourceLocation& where) {
  constexpr std::int64_t kMaxPixels = 1'000'000'000;
  if (std::int64_t{width} * height > kMaxPixels)
    throw SceneError(where, "the picture has " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels, expected at most 10^9");
}

Description read_scene(const std::filesystem::path& file, const ReadOptions& options) {
  const ExpandedScene scene(file, options.defines);
  const XmlElement& root = scene.root();
  if (root.name != "scene") throw SceneError(root.where, "root element is <" + root.name + ">, expected <scene>");
  Description description;
  description.file = file;
  ReadContext context{scene, description, options.lenient};
  context.readers.spectrum = read_property_spectrum;
  context.readers.scalar_texture = scalar_texture;
  if (dialect_score(root) < 0) {
    read_nori(context);
  } else {
    read_mitsuba(context);
  }
  description.files = scene.files();
  expand_obj_materials(description);
  return description;
}

}  // namespace sheaf

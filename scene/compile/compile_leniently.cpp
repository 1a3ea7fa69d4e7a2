// Compilation that drops or replaces broken elements: broken files are only detected when they are read.
#include "scene/compile/compile.h"

#include <algorithm>

namespace sheaf {

namespace {

bool is_at(const SourceLocation& where, const std::string& message) {
  return !where.file.empty() && message.starts_with(SceneError(where, "").what());
}

template <class Items> auto find_at(Items& items, const std::string& message) {
  return std::find_if(items.begin(), items.end(), [&](const auto& item) { return is_at(item.where, message); });
}

template <class Items> bool erase_at(Items& items, const std::string& message) {
  const auto found = find_at(items, message);
  if (found == items.end()) return false;
  items.erase(found);
  return true;
}

/// Replaces an element that others refer to by index.
template <class Items, class Item> bool replace_at(Items& items, const std::string& message, Item&& by) {
  const auto found = find_at(items, message);
  if (found == items.end()) return false;
  *found = std::forward<Item>(by);
  return true;
}

TextureDescription grey_texture() {
  TextureDescription texture;
  texture.model = ConstantTextureDescription{SpectrumDescription::constant(0.5f)};
  return texture;
}

MediumDescription empty_medium() {
  MediumDescription medium;
  medium.coefficients =
      AbsorptionScatteringDescription{SpectrumDescription::constant(0), SpectrumDescription::constant(0)};
  return medium;
}

/// Removes or replaces the element that caused the message. Returns a description of the action, or null if the element
/// is not found.
const char* remove_culprit(const std::string& message, Description& description) {
  if (replace_at(description.textures, message, grey_texture())) return "the texture is grey";
  if (erase_at(description.lights, message)) return "light left out";
  if (replace_at(description.media, message, empty_medium())) return "the medium is empty";
  if (replace_at(description.materials, message, MaterialDescription())) return "a diffuse surface stands in";
  if (erase_at(description.shapes, message)) return "shape left out";
  for (ShapeGroup& group : description.groups)
    if (erase_at(group.shapes, message)) return "shape left out";
  if (!is_at(description.camera.where, message)) return nullptr;
  const CameraDescription standard;
  description.camera.near_clip = standard.near_clip;
  description.camera.far_clip = standard.far_clip;
  description.camera.fov = standard.fov;
  description.camera.where = {};
  return "the camera's usual lens stands in";
}

}  // namespace

std::unique_ptr<Scene> compile_leniently(Description& description, const CompileOptions& options) {
  for (;;) {
    try {
      return compile_scene(description, options);
    } catch (const SceneError& error) {
      const std::string message = error.what();
      const char* done = remove_culprit(message, description);
      if (done == nullptr) throw;
      description.stand_ins.push_back(message + " (" + done + ")");
    }
  }
}

}  // namespace sheaf

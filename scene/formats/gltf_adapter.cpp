// Valid glTF that the library rejects, in a form that it accepts.
#include "scene/formats/gltf_document.h"

#include <nlohmann/json.hpp>

namespace sheaf {

using nlohmann::json;

namespace {

/// Calls f(element, index) for the objects in an array member, if there is one.
template <class F> void for_each_object(json& parent, const char* name, F&& f) {
  const auto found = parent.find(name);
  if (found == parent.end() || !found->is_array()) return;
  for (std::size_t i = 0; i < found->size(); ++i)
    if ((*found)[i].is_object()) f((*found)[i], i);
}

/// By accessor, whether it has no buffer view: its elements are zero, sparse or compressed.
std::vector<bool> find_accessors_without_view(json& document) {
  std::vector<bool> found;
  for_each_object(document, "accessors", [&](const json& accessor, std::size_t i) {
    found.resize(i + 1);
    found[i] = !accessor.contains("bufferView");
  });
  return found;
}

/// Removes the indices of primitives whose triangles are compressed, and renames indices without a buffer view: the
/// library looks for their data.
void adapt_indices(json& document) {
  const std::vector<bool> without_view = find_accessors_without_view(document);
  const auto adapt = [&](json& primitive, std::size_t) {
    if (!primitive.contains("indices")) return;
    const json indices = primitive["indices"];
    if (primitive.contains(json::json_pointer("/extensions/KHR_draco_mesh_compression"))) {
      primitive.erase("indices");
    } else if (indices.is_number_unsigned() && indices < without_view.size() &&
               without_view[indices.get<std::size_t>()]) {
      primitive.erase("indices");
      json& extensions = primitive["extensions"];
      if (!extensions.is_object()) extensions = json::object();
      extensions[kIndicesWithoutView] = {{"accessor", indices}};
    }
  };
  for_each_object(document, "meshes", [&](json& mesh, std::size_t) { for_each_object(mesh, "primitives", adapt); });
}

/// Sets the inverse bind matrices of skins that have none to "no accessor": the library takes them for required.
void adapt_skins(json& document) {
  for_each_object(document, "skins", [](json& skin, std::size_t) {
    if (!skin.contains("inverseBindMatrices")) skin["inverseBindMatrices"] = kNoIndex;
  });
}

/// Whether a channel of an animation is valid and does not animate a node.
bool lacks_node(const json& channel) {
  const json::json_pointer target("/target");
  return channel.contains(target) && channel[target].is_object() && !channel[target].contains("node");
}

/// Removes the channels of animations that do not animate a node (glTF 2.0, 3.11: they should be ignored).
void adapt_animations(json& document, GltfFile& out) {
  for_each_object(document, "animations", [&](json& animation, std::size_t i) {
    const auto found = animation.find("channels");
    if (found == animation.end() || !found->is_array()) return;
    const std::size_t removed = std::erase_if(found->get_ref<json::array_t&>(), lacks_node);
    if (removed == 0) return;
    const std::string what = removed == 1 ? "1 channel does" : fmt::format("{} channels do", removed);
    out.notes.push_back(out.error(fmt::format("animations[{}]", i), what + " not animate a node (ignored)").what());
  });
}

}  // namespace

void adapt_document(nlohmann::json& document, GltfFile& out) {
  adapt_indices(document);
  adapt_skins(document);
  adapt_animations(document, out);
}

}  // namespace sheaf

#include "tools/importer/conversion.h"

namespace sheaf::importer {

std::string to_glb(const aiScene& scene, const std::string& format, FileParts parts) {
  Conversion to{scene, format, std::move(parts)};
  to.notes = std::move(to.parts.notes);
  to.glb.json["asset"]["generator"] = "Sheaf, by Assimp";
  to.glb.json["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_specular"};
  add_materials(to);
  add_nodes(to);
  add_animations(to);
  if (!to.notes.empty()) to.glb.json["asset"]["extras"]["notes"] = to.notes;
  return to.glb.bytes();
}

}  // namespace sheaf::importer

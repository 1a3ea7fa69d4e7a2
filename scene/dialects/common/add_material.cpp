// Appending of materials.
#include "scene/dialects/common/add_material.h"

namespace sheaf {

MaterialId add_material(ReadContext& context, MaterialDescription material) {
  context.description.materials.push_back(std::move(material));
  return static_cast<MaterialId>(context.description.materials.size() - 1);
}

}  // namespace sheaf

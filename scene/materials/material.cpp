// Whether materials transmit light, including nested materials.
#include "scene/materials/material.h"

namespace sheaf {

bool NestedTransmission::operator()(MaterialId id) const { return transmits(materials, id, depth + 1); }

bool transmits(const std::vector<MaterialDescription>& materials, MaterialId id, int depth) {
  if (depth > kMaxMaterialDepth) return false;
  const NestedTransmission nested{materials, depth};
  return std::visit(
      [&](const auto& model) {
        if constexpr (requires { model.transmits(nested); })
          return model.transmits(nested);
        else
          return model.transmits();
      },
      materials.at(static_cast<std::size_t>(id)).model);
}

}  // namespace sheaf

// Whether materials transmit light, including nested materials.
#include "scene/description/description.h"

namespace sheaf {

namespace {

struct Transmits {
  const std::vector<MaterialDescription>& materials;
  int depth;

  template <class Model> bool operator()(const Model& model) const { return model.transmits(); }
  bool operator()(const TwoSidedDescription&) const { return false; }
  bool operator()(const BlendDescription& blend) const { return nested(blend.nested[0]) || nested(blend.nested[1]); }
  bool operator()(const CoatDescription& coat) const { return nested(coat.nested); }
  bool operator()(const BumpMapDescription& bump) const { return nested(bump.nested); }
  bool operator()(const NormalMapDescription& map) const { return nested(map.nested); }

  bool nested(MaterialId id) const { return transmits(materials, id, depth + 1); }
};

}  // namespace

bool transmits(const std::vector<MaterialDescription>& materials, MaterialId id, int depth) {
  if (depth > kMaxMaterialDepth) return false;
  return std::visit(Transmits{materials, depth}, materials.at(static_cast<std::size_t>(id)).model);
}

}  // namespace sheaf

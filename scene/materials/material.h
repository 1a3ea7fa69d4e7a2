// A material of a scene, of any model.
#pragma once

#include "core/io/error.h"
#include "scene/materials/list.h"

#include <string>
#include <vector>

namespace sheaf {

struct MaterialDescription {
  MaterialModel model;
  std::string id;  ///< name for messages; may be empty
  SourceLocation where;
};

/// Maximum nesting depth of materials.
inline constexpr int kMaxMaterialDepth = 16;

/// Whether light can pass through a material or one nested in it. `depth` is the nesting depth of `id`. Materials
/// nested deeper than kMaxMaterialDepth count as opaque.
bool transmits(const std::vector<MaterialDescription>& materials, MaterialId id, int depth = 0);

}  // namespace sheaf

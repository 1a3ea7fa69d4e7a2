// Builds the SceneNames of a scene.
#pragma once

#include "scene/description.h"
#include "scene/tables/scene_names.h"

#include <unordered_map>

namespace sheaf {

/// Names rows as they are added.
class SceneNaming {
 public:
  explicit SceneNaming(SceneNames& names) : names_(names) {}

  /// Names all materials of a description.
  void add_materials(const std::vector<MaterialDescription>& materials);
  /// Names the next row of shapes. `group`: its group; null: none.
  void add_shape(const ShapeDescription& shape, const ShapeGroup* group);
  /// Names the next row of lights; lights without a `name` share that of `label`, which names their kind.
  void add_light(const std::string& label, const std::string& name);

 private:
  using Index = std::unordered_map<std::string, std::uint32_t>;
  static std::uint32_t index_of(const std::string& name, Index& index, std::vector<std::string>& names);

  SceneNames& names_;
  Index objects_, lights_;
};

/// The name of a shape's area light; may be empty.
inline const std::string& emitter_name(const ShapeDescription& shape) {
  return shape.emitter_id.empty() ? shape.id : shape.emitter_id;
}

}  // namespace sheaf

// Names of objects, materials and lights as given in scene files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sheaf {

/// Names of objects, materials and lights, and the rows of tables to which they belong. Unnamed ones get a name from
/// their kind and a number. Objects with the same name count as one, and so do lights.
struct SceneNames {
  std::vector<std::string> objects;    ///< unique
  std::vector<std::string> materials;  ///< by MaterialId, then "default"; may contain duplicates
  std::vector<std::string> lights;     ///< unique, except that a kind's name may also be the name of a light
  std::vector<std::uint32_t> object_of_shape,
      material_of_shape;                    ///< by row of GeometryView::shapes: index into the above
  std::vector<std::uint32_t> light_of_row;  ///< by row of LightView::rows
  bool has_other_light = false;             ///< a medium emits without a row in the table of lights
};

}  // namespace sheaf

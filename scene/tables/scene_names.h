// What files call the parts of a scene: for layers that tell these apart.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sheaf {

/// Names of objects, materials and lights, and which of them the rows of the scene's tables belong to. Where files give
/// no name there is one made of the kind and a number. Objects of the same name are one, as are lights.
struct SceneNames {
  std::vector<std::string> objects;    ///< each once
  std::vector<std::string> materials;  ///< by MaterialId, then "default"; some may be the same
  std::vector<std::string> lights;     ///< each once, but that a kind's name may be some light's too
  std::vector<std::uint32_t> object_of_shape, material_of_shape;  ///< by row of SceneView::shapes: index into the above
  std::vector<std::uint32_t> light_of_row;                        ///< by row of SceneView::lights
  bool has_other_light = false;                                   ///< a medium glows without being a row of lights
};

}  // namespace sheaf

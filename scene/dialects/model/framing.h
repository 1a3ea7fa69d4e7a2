// A camera that frames a model: its silhouette fills two thirds of the image.
#pragma once

#include "scene/description.h"
#include "scene/dialects/model/model_view.h"

#include <array>

namespace sheaf {

/// A model as the camera sees it. All vectors are unit vectors.
struct ModelFrame {
  Vec3d center;                      ///< of the bounds
  double radius = 0;                 ///< of the bounding sphere around `center`; positive
  Vec3d right, up;                   ///< axes of the image
  Vec3d front;                       ///< from the model to the camera
  double bottom = 0;                 ///< smallest coordinate of the model along floor_normal(), relative to `center`
  Vec3d floor_normal;                ///< the up axis; from below, `up`
  Vec3d eye;                         ///< position of the camera
  std::array<double, 2> tangents{};  ///< of half the field of view along `right` and `up`
};

/// Places the camera such that the projection of all shapes fills two thirds of the image along one axis, and at most
/// that along the other, from the direction of `view`; less for very wide fields of view. `box`: their bounds. Their
/// meshes must be in memory.
ModelFrame frame_model(const std::array<Vec3d, 2>& box, const ModelView& view, Description& description);

}  // namespace sheaf

// Emissive disks and cylinders, and spheres that are stretched or emit inwards.
#pragma once

#include "scene/tables/light.h"

namespace sheaf {

/// Data of a quadric as a light.
template <class L> struct QuadricLightData {
  typename L::Uint shape;            ///< into SceneView::shapes
  typename L::Uint quadric;          ///< into SceneView::quadrics
  typename L::Float canonical_area;  ///< see canonical_area()
  typename L::Float min_offset;      ///< minimum distance by which points are moved off the surface, metres

  static constexpr auto fields(auto& s) { return std::tie(s.shape, s.quadric, s.canonical_area, s.min_offset); }
};

}  // namespace sheaf

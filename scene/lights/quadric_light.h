// Emissive disks and cylinders, and spheres that are stretched or emit inwards.
#pragma once

#include "scene/lights/light.h"

namespace sheaf {

/// Data of a quadric as a light.
template <class L> struct QuadricLightData {
  typename L::Uint shape;            ///< into GeometryView::shapes
  typename L::Uint quadric;          ///< into GeometryView::quadrics
  typename L::Float canonical_area;  ///< see canonical_area()
  typename L::Float min_offset;      ///< minimum distance by which points are moved off the surface, meters

  static constexpr auto fields(auto& s) { return std::tie(s.shape, s.quadric, s.canonical_area, s.min_offset); }
};

/// See scene/lights/light.h.
struct QuadricLightKind {
  static constexpr const char* kLabel = "area";
  static constexpr LightDomain kDomain = LightDomain::kBounded;
  using Descriptions = LightDescriptions<>;

  static Vec3f power(const SceneView& scene, const LightRow& light);
  static LightBounds bounds(const SceneView& scene, const LightRow& light, double power);
  static Vec3f integral(const SceneView& scene, const LightRow& light, int points);
  static IntegralSharing integral_key(const SceneView& scene, const LightRow& light, std::vector<std::uint32_t>& key);
};

}  // namespace sheaf

// Lights as rows of a table, and their power.
#pragma once

#include "scene/scene.h"

namespace sheaf {

/// The tables that area lights are made from.
struct ShapeTables {
  const float* positions;
  const std::uint32_t* triangles;
  const QuadricRow* quadrics;
};

/// A light and the weight by which it is selected: its power in W, averaged over R, G and B.
struct PlacedLight {
  LightRow row;
  float power;
};
/// An area light with the alias table over its triangles (meshes only).
struct AreaLight {
  LightRow row;
  float power;
  std::vector<AliasEntry> triangles;
};

/// `alias_offset`: where `triangles` will stand in SceneView::triangle_alias.
AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables, Vec3f radiance,
                          std::uint32_t alias_offset);
PlacedLight make_point_light(Vec3f intensity, Vec3f position);
/// `radius`: of the sphere around the scene.
PlacedLight make_constant_light(Vec3f radiance, float radius);

}  // namespace sheaf

// Lights as rows of a table, and their power.
#pragma once

#include "scene/scene.h"

namespace sheaf {

/// The tables that area lights are made from.
struct ShapeTables {
  const VertexRow* vertices;
  const std::uint32_t* triangles;
  const QuadricRow* quadrics;
};

/// A light and the weight by which it is selected: its power in W, averaged over R, G and B.
struct PlacedLight {
  LightRow row;
  float power;
};
/// An area light with its triangles and the alias table over them (meshes only).
struct AreaLight {
  LightRow row;
  float power;
  std::vector<AliasEntry> alias;
  std::vector<LightTriangleRow> triangles;
};

/// `first_triangle`: where `triangles` and `alias` will stand in the scene's tables.
AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables, Vec3f radiance,
                          std::uint32_t first_triangle);
PlacedLight make_point_light(Vec3f intensity, Vec3f position);
/// `radius`: of the sphere around the scene.
PlacedLight make_constant_light(Vec3f radiance, float radius);

}  // namespace sheaf

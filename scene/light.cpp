#include "scene/light.h"

#include "scene/quadric.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Selection weights must be positive and finite however large the light.
float selection_power(Vec3f radiance, double factor) {
  const double power = (double(radiance.x) + radiance.y + radiance.z) / 3.0 * factor;
  return static_cast<float>(std::clamp(power, 1e-30, 1e30));
}

double triangle_area(const ShapeTables& tables, const ShapeRow& shape, std::uint32_t triangle) {
  double p[3][3];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t vertex = tables.triangles[3 * (std::size_t(shape.first_triangle) + triangle) + k];
    for (std::size_t c = 0; c < 3; ++c) p[k][c] = tables.positions[3 * (std::size_t(shape.first_vertex) + vertex) + c];
  }
  double squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3;
    const double n = (p[1][c] - p[0][c]) * (p[2][d] - p[0][d]) - (p[1][d] - p[0][d]) * (p[2][c] - p[0][c]);
    squared += n * n;
  }
  return 0.5 * std::sqrt(squared);
}

void set_radiance(LightRow& row, Vec3f value) {
  row.radiance[0] = value.x;
  row.radiance[1] = value.y;
  row.radiance[2] = value.z;
}

}  // namespace

AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables, Vec3f radiance,
                          std::uint32_t alias_offset) {
  AreaLight light;
  LightRow& row = light.row;
  row.shape = shape_index;
  set_radiance(row, radiance);
  double area = 0;
  if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh) {
    row.kind = static_cast<std::uint32_t>(LightKind::kMesh);
    row.first_triangle = alias_offset;
    row.triangle_count = shape.triangle_count;
    std::vector<float> areas;
    for (std::uint32_t i = 0; i < shape.triangle_count; ++i) areas.push_back(static_cast<float>(triangle_area(tables, shape, i)));
    for (float a : areas) area += a;
    light.triangles = build_alias_table(areas);
    row.area = static_cast<float>(area);
  } else {
    const QuadricRow& q = tables.quadrics[shape.first_triangle];
    area = quadric_area(q);
    // Light leaves a flipped sphere inwards, where the cone of directions that see it says nothing.
    const bool cone = q.kind == ShapeKind::kSphere && q.uniform_scale > 0.0f && q.normal_sign > 0.0f;
    row.kind = static_cast<std::uint32_t>(cone ? LightKind::kSphere : LightKind::kQuadric);
    row.area = canonical_area(q.kind);
    row.radius = q.uniform_scale;
    row.position[0] = q.to_world[3];
    row.position[1] = q.to_world[7];
    row.position[2] = q.to_world[11];
  }
  light.power = selection_power(radiance, kPi * area);
  return light;
}

PlacedLight make_point_light(Vec3f intensity, Vec3f position) {
  LightRow row;
  row.kind = static_cast<std::uint32_t>(LightKind::kPoint);
  set_radiance(row, intensity);
  row.position[0] = position.x;
  row.position[1] = position.y;
  row.position[2] = position.z;
  return {row, selection_power(intensity, 4.0 * kPi)};
}

PlacedLight make_constant_light(Vec3f radiance, float radius) {
  LightRow row;
  row.kind = static_cast<std::uint32_t>(LightKind::kConstant);
  set_radiance(row, radiance);
  return {row, selection_power(radiance, kPi * double(kPi) * radius * radius)};
}

}  // namespace sheaf

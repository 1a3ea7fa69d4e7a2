#include "scene/light.h"

#include "scene/quadric.h"
#include "scene/shape.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Selection weights must be positive and finite however large the light.
float selection_power(Vec3f radiance, double factor) {
  const double power = (double(radiance.x) + radiance.y + radiance.z) / 3.0 * factor;
  return static_cast<float>(std::clamp(power, 1e-30, 1e30));
}

struct TriangleWithArea {
  LightTriangleRow row{};
  double area = 0;
};

TriangleWithArea make_triangle(const ShapeTables& tables, const ShapeRow& shape, std::uint32_t triangle) {
  double p[3][3];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t vertex = tables.triangles[3 * (std::size_t(shape.first_triangle) + triangle) + k];
    for (std::size_t c = 0; c < 3; ++c) p[k][c] = tables.vertices[std::size_t(shape.first_vertex) + vertex].position[c];
  }
  double normal[3], squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
    normal[c] = (p[1][d] - p[0][d]) * (p[2][e] - p[0][e]) - (p[1][e] - p[0][e]) * (p[2][d] - p[0][d]);
    squared += normal[c] * normal[c];
  }
  const double twice_area = std::sqrt(squared);
  TriangleWithArea out;
  out.area = 0.5 * twice_area;
  double across = 0, extent = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double largest = std::max({std::fabs(p[0][c]), std::fabs(p[1][c]), std::fabs(p[2][c])});
    out.row.p[c] = static_cast<float>(p[0][c]);
    out.row.edge1[c] = static_cast<float>(p[1][c] - p[0][c]);
    out.row.edge2[c] = static_cast<float>(p[2][c] - p[0][c]);
    out.row.normal[c] = static_cast<float>(normal[c] / twice_area);
    across += std::fabs(out.row.normal[c]) * largest;
    extent = std::max(extent, largest);
  }
  out.row.offset = static_cast<float>(kOffsetUlps * (across + extent));
  return out;
}

void set_radiance(LightRow& row, Vec3f value) {
  row.radiance[0] = value.x;
  row.radiance[1] = value.y;
  row.radiance[2] = value.z;
}

}  // namespace

AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables, Vec3f radiance,
                          std::uint32_t first_triangle) {
  AreaLight light;
  LightRow& row = light.row;
  row.shape = shape_index;
  set_radiance(row, radiance);
  double area = 0;
  if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh) {
    row.kind = static_cast<std::uint32_t>(LightKind::kMesh);
    row.first_triangle = first_triangle;
    row.triangle_count = shape.triangle_count;
    std::vector<float> areas;
    for (std::uint32_t i = 0; i < shape.triangle_count; ++i) {
      const TriangleWithArea triangle = make_triangle(tables, shape, i);
      light.triangles.push_back(triangle.row);
      areas.push_back(static_cast<float>(triangle.area));
      area += areas.back();
    }
    light.alias = build_alias_table(areas);
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

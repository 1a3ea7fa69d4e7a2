#include "scene/lights/rectangle_light.h"

#include "scene/lights/area_light.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace sheaf {

namespace {

/// The triangle with its vertices rotated: vertex `first` comes first.
LightTriangleRow rotated(const LightTriangleRow& t, std::uint32_t first) {
  LightTriangleRow out = t;
  if (first == 1) out.p = t.p + t.edge1, out.edge1 = t.edge2 - t.edge1, out.edge2 = -t.edge1;
  if (first == 2) out.p = t.p + t.edge2, out.edge1 = -t.edge2, out.edge2 = t.edge1 - t.edge2;
  return out;
}

/// The vertex at the right angle of a triangle, if there is one.
std::optional<std::uint32_t> right_angle(const LightTriangleRow& triangle) {
  constexpr float kMaxCosine = 1e-4f;
  for (std::uint32_t vertex = 0; vertex < 3; ++vertex) {
    const LightTriangleRow t = rotated(triangle, vertex);
    const float scale = length(t.edge1) * length(t.edge2);
    if (scale > 0.0f && std::fabs(dot(t.edge1, t.edge2)) <= kMaxCosine * scale) return vertex;
  }
  return std::nullopt;
}

}  // namespace

void complete_rectangle_light(AreaLight& light) {
  if (light.triangles.size() != 2) return;
  const auto vertex0 = right_angle(light.triangles[0]), vertex1 = right_angle(light.triangles[1]);
  if (!vertex0 || !vertex1) return;
  LightTriangleRow a = rotated(light.triangles[0], *vertex0), b = rotated(light.triangles[1], *vertex1);
  // Both triangles must share the hypotenuse and the normal, up to the error that ray offsets allow for
  const float slack = std::max(a.offset, b.offset);
  const auto close = [slack](Vec3f p, Vec3f q) { return max_component(abs(p - q)) <= slack; };
  if (!close(a.p + a.edge1, b.p + b.edge2) || !close(a.p + a.edge2, b.p + b.edge1)) return;
  if (!close(a.edge1, -b.edge1) || dot(a.normal, b.normal) < 0.0f) return;
  a.offset = b.offset = 2.0f * slack;
  for (LightTriangleRow* row : {&a, &b}) {
    row->inverse_length1 = 1.0f / length(row->edge1);
    row->inverse_length2 = 1.0f / length(row->edge2);
  }
  light.triangles = {a, b};
  light.row.kind = static_cast<std::uint32_t>(kLightKind<RectangleLightKind>);
  light.row.set_data(RectangleLightData<Scalar>{light.row.data<MeshLightData>(), *vertex0, *vertex1});
}

}  // namespace sheaf

#include "scene/lights/area_light.h"

#include "scene/surfaces/shape.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                          const AreaEmission& emission, const LightTableOffsets& offsets,
                          const LightInstance* instance) {
  AreaLight light;
  light.row.texture = emission.texture;
  if (emission.texture != kNone || emission.coat.texture != kNone) light.row.flags |= kNeedsTextureQuery;
  if (emission.along_normal) light.row.flags |= kEmitsAlongNormal;
  if (emission.two_sided) light.row.flags |= kEmitsOnBothSides;
  if (emission.missed_by_rays) light.row.flags |= kMissedByRays;
  light.row.radiance = {emission.radiance.x, emission.radiance.y, emission.radiance.z, 0.0f};
  if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh) {
    complete_mesh_light(light, shape, shape_index, tables, offsets, instance);
  } else {
    complete_quadric_light(light, shape, shape_index, tables, offsets, instance);
  }
  return light;
}

float LightInstance::offset(Vec3f p, Vec3f ng, float offset) const {
  const auto placed_at = [&](const InstanceRow& row) {
    SurfacePoint<Scalar> y{};
    y.p = p;
    y.ng = y.ns = ng;
    y.offset = offset;
    place_instance<Scalar, false>(InstancePlacement<Scalar>(row), true, y);
    return y;
  };
  float largest = placed_at(rest).offset;
  const Vec3f normal = InstancePlacement<Scalar>(rest).normal(ng);
  for (const Step& step : steps) {
    // Rounding of the time, as in MotionSample::error()
    const float* m = step.speed.data();
    const Vec3f q = abs(p);
    const Vec3f moved{m[0] * q.x + m[1] * q.y + m[2] * q.z + m[3], m[4] * q.x + m[5] * q.y + m[6] * q.z + m[7],
                      m[8] * q.x + m[9] * q.y + m[10] * q.z + m[11]};
    const float in_world = placed_at(step.placed).offset + kOffsetUlps * max_component(moved);
    // An affine map scales distances from a plane by det M / |cof M n|
    const InstancePlacement<Scalar> placed(step.placed);
    const float scale = length(placed.normal(ng)) / length(normal) * std::fabs(rest.determinant / placed.determinant);
    largest = std::max(largest, in_world * scale);
  }
  return largest;
}

}  // namespace sheaf

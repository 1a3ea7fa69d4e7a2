#include "scene/lights/area_light.h"

#include "scene/tables/shape.h"

namespace sheaf {

AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                          const AreaEmission& emission, const LightPlaces& places, const InstanceRow* instance) {
  AreaLight light;
  light.row.texture = emission.texture;
  if (emission.texture != kNone || emission.coat.texture != kNone) light.row.flags |= kNeedsTextureQuery;
  if (emission.along_normal) light.row.flags |= kEmitsAlongNormal;
  if (emission.two_sided) light.row.flags |= kEmitsOnBothSides;
  if (emission.missed_by_rays) light.row.flags |= kMissedByRays;
  light.row.radiance = {emission.radiance.x, emission.radiance.y, emission.radiance.z, 0.0f};
  if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh) {
    complete_mesh_light(light, shape, shape_index, tables, places, instance);
  } else {
    complete_quadric_light(light, shape, shape_index, tables, places, instance);
  }
  return light;
}

float instance_offset(const InstanceRow& instance, Vec3f p, Vec3f ng, float offset) {
  SurfacePoint<Scalar> y{};
  y.p = p;
  y.ng = y.ns = ng;
  y.offset = offset;
  place_instance<Scalar, false>(InstancePlacement<Scalar>(instance), true, y);
  return y.offset;
}

}  // namespace sheaf

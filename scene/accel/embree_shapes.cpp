// Quadrics and cells of SDF grids are user geometries with callbacks for their bounds and intersections. Meshes and
// curves are Embree's own; a filter culls the inside of curves.
#include "scene/accel/embree_shapes.h"

#include "scene/accel/quadric.h"

namespace sheaf {

namespace {

void write_bounds(const RTCBoundsFunctionArguments* args, const Bounds3f& b) {
  *args->bounds_o = {b.min.x, b.min.y, b.min.z, 0, b.max.x, b.max.y, b.max.z, 0};
}
void bounds_callback(const RTCBoundsFunctionArguments* args) {
  write_bounds(args, quadric_bounds(*static_cast<const QuadricRow*>(args->geometryUserPtr)));
}
void sdf_bounds_callback(const RTCBoundsFunctionArguments* args) {
  write_bounds(args, sdf_cell_bounds(*static_cast<const SdfGridView*>(args->geometryUserPtr), args->primID));
}

/// Intersection functions of user geometries, for one primitive at a time.
struct QuadricSurface {
  static std::optional<QuadricHit> intersect(const void* quadric, std::uint32_t /*primitive*/, Vec3f origin,
                                             Vec3f direction, float t_near, float t_far) {
    return intersect_quadric(*static_cast<const QuadricRow*>(quadric), origin, direction, t_near, t_far);
  }
};
struct SdfSurface {
  static std::optional<QuadricHit> intersect(const void* grid, std::uint32_t cell, Vec3f origin, Vec3f direction,
                                             float t_near, float t_far) {
    return intersect_sdf_cell(*static_cast<const SdfGridView*>(grid), cell, origin, direction, t_near, t_far);
  }
};

/// Intersects ray `i` of `n` with the surface.
template <class Surface>
std::optional<QuadricHit> intersect_one(const void* surface, std::uint32_t primitive, RTCRayN* rays, unsigned n,
                                        unsigned i) {
  const Vec3f origin{RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)};
  const Vec3f direction{RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)};
  return Surface::intersect(surface, primitive, origin, direction, RTCRayN_tnear(rays, n, i), RTCRayN_tfar(rays, n, i));
}

template <class Surface> void intersect_callback(const RTCIntersectFunctionNArguments* args) {
  RTCRayN* rays = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* hits = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const auto hit = intersect_one<Surface>(args->geometryUserPtr, args->primID, rays, args->N, i);
    if (!hit) continue;
    RTCRayN_tfar(rays, args->N, i) = hit->t;
    RTCHitN_Ng_x(hits, args->N, i) = hit->normal.x;
    RTCHitN_Ng_y(hits, args->N, i) = hit->normal.y;
    RTCHitN_Ng_z(hits, args->N, i) = hit->normal.z;
    RTCHitN_u(hits, args->N, i) = RTCHitN_v(hits, args->N, i) = 0.0f;
    RTCHitN_primID(hits, args->N, i) = args->primID;
    RTCHitN_geomID(hits, args->N, i) = args->geomID;
    RTCHitN_instID(hits, args->N, i, 0) = args->context->instID[0];
  }
}

template <class Surface> void occluded_callback(const RTCOccludedFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i)
    if (args->valid[i] != 0 && intersect_one<Surface>(args->geometryUserPtr, args->primID, args->ray, args->N, i))
      RTCRayN_tfar(args->ray, args->N, i) = -kInfinity;
}

RTCGeometry make_mesh(RTCDevice device, const AccelInput& in, const ShapeRow& shape, std::uint32_t vertex_count) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const DeformationRow* motion = in.motion.deformation(shape);
  const std::uint32_t segments = motion != nullptr ? motion->segment_count : 0;
  if (segments > 0) rtcSetGeometryTimeStepCount(geometry, segments + 1);
  for (std::uint32_t step = 0; step <= segments; ++step)
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3,
                               in.vertices + shape.first_vertex + std::size_t(step) * vertex_count, 0,
                               sizeof(VertexRow), vertex_count);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             in.triangles + 3 * std::size_t(shape.first_triangle), 0, 12, shape.triangle_count);
  return geometry;
}

RTCGeometry make_quadric_geometry(RTCDevice device, const QuadricRow& row) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryUserData(geometry, const_cast<QuadricRow*>(&row));
  rtcSetGeometryBoundsFunction(geometry, bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback<QuadricSurface>);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback<QuadricSurface>);
  return geometry;
}

/// One primitive per cell that contains the surface. `grid` must not move.
RTCGeometry make_sdf_geometry(RTCDevice device, const SdfGridView& grid, std::uint32_t cell_count) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, cell_count);
  rtcSetGeometryUserData(geometry, const_cast<SdfGridView*>(&grid));
  rtcSetGeometryBoundsFunction(geometry, sdf_bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback<SdfSurface>);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback<SdfSurface>);
  return geometry;
}

/// Culls back faces of curves: rays that leave a curve could otherwise hit it from inside due to rounding.
void cull_inside(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    const Vec3f direction{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                          RTCRayN_dir_z(args->ray, args->N, i)};
    const Vec3f normal{RTCHitN_Ng_x(args->hit, args->N, i), RTCHitN_Ng_y(args->hit, args->N, i),
                       RTCHitN_Ng_z(args->hit, args->N, i)};
    if (!(dot(normal, direction) < 0.0f)) args->valid[i] = 0;
  }
}

RTCGeometry make_curves(RTCDevice device, const AccelInput& in, const ShapeRow& shape, std::uint32_t point_count) {
  const bool linear = static_cast<ShapeKind>(shape.kind) == ShapeKind::kLinearCurves;
  RTCGeometry geometry =
      rtcNewGeometry(device, linear ? RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE : RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE);
  const DeformationRow* motion = in.motion.deformation(shape);
  const std::uint32_t segments = motion != nullptr ? motion->segment_count : 0;
  if (segments > 0) rtcSetGeometryTimeStepCount(geometry, segments + 1);
  for (std::uint32_t step = 0; step <= segments; ++step)
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4,
                               in.curve_points + shape.first_vertex + std::size_t(step) * point_count, 0,
                               sizeof(CurvePointRow), point_count);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT,
                             in.curve_segments + shape.first_triangle, 0, sizeof(std::uint32_t), shape.triangle_count);
  rtcSetGeometryIntersectFilterFunction(geometry, cull_inside);
  rtcSetGeometryOccludedFilterFunction(geometry, cull_inside);
  if (!linear) return geometry;
  // With these flags, Embree joins neighboring segments without a surface in between.
  auto* flags = static_cast<std::uint8_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR, 1, shape.triangle_count));
  const std::uint32_t* first = in.curve_segments + shape.first_triangle;
  for (std::uint32_t i = 0; flags != nullptr && i < shape.triangle_count; ++i) {
    const bool after = i > 0 && first[i - 1] + 1 == first[i];
    const bool before = i + 1 < shape.triangle_count && first[i] + 1 == first[i + 1];
    flags[i] = static_cast<std::uint8_t>((after ? RTC_CURVE_FLAG_NEIGHBOR_LEFT : 0) |
                                         (before ? RTC_CURVE_FLAG_NEIGHBOR_RIGHT : 0));
  }
  return geometry;
}

}  // namespace

RTCGeometry make_embree_shape(RTCDevice device, const AccelInput& in, std::uint32_t i, std::deque<SdfGridView>& grids) {
  const ShapeRow& shape = in.shapes[i];
  switch (static_cast<ShapeKind>(shape.kind)) {
    case ShapeKind::kMesh:
      return make_mesh(device, in, shape, in.vertex_counts[i]);
    case ShapeKind::kLinearCurves:
    case ShapeKind::kBsplineCurves:
      return make_curves(device, in, shape, in.vertex_counts[i]);
    case ShapeKind::kSdfGrid:
      grids.push_back(sdf_grid_view(in.quadrics, in.sdf_grids[shape.first_vertex], shape, in.sdf_values, in.sdf_cells));
      return make_sdf_geometry(device, grids.back(), shape.triangle_count);
    default:
      return make_quadric_geometry(device, in.quadrics[shape.first_triangle]);
  }
}

}  // namespace sheaf

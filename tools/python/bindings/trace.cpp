#include "tools/python/bindings/trace.h"

#include "core/soa/lane_array.h"
#include "scene/accel/accel.h"
#include "scene/surfaces/shape.h"

#include <algorithm>

namespace sheaf {

namespace {

RayHits make_hits(std::size_t count) {
  RayHits hits;
  hits.distance.assign(count, kInfinity);
  hits.position.resize(count);
  hits.normal.resize(count);
  hits.shading_normal.resize(count);
  hits.uv.resize(2 * count);
  hits.barycentric.resize(2 * count);
  hits.shape.assign(count, kNone);
  hits.primitive.resize(count);
  hits.instance.assign(count, kNone);
  return hits;
}

/// Stores the hits of lanes [at, at + count) of a packet, at most kWidth, as those of the rays from `first`.
void store_tile(const SceneView& scene, const RayPacket& packet, int at, int count, std::size_t first, RayHits& hits) {
  using L = Wide;
  using F = Float<L>;
  using U = Uint<L>;
  Vec3<L> origin, direction;
  F t, u, v;
  U primitive, shape_row, instance;
  load(packet.origin_x + at, origin.x), load(packet.origin_y + at, origin.y), load(packet.origin_z + at, origin.z);
  load(packet.direction_x + at, direction.x), load(packet.direction_y + at, direction.y);
  load(packet.direction_z + at, direction.z);
  load(packet.t_far + at, t), load(packet.u + at, u), load(packet.v + at, v);
  load(packet.primitive + at, primitive), load(packet.shape + at, shape_row), load(packet.instance + at, instance);
  const Mask<L> found = shape_row != U(kNone);
  if (!any(found)) return;
  const auto safe = [&](U row) { return select(found, row, U(0u)); };
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, safe(shape_row));
  const SurfacePoint<L> point = surface_point<L, true>(
      scene, shape, safe(primitive), select(found, u, F(0.0f)), select(found, v, F(0.0f)),
      origin + direction * select(found, t, F(0.0f)), select(found, instance, U(kNone)), F(0.0f));
  const LaneRows<L, Vec3> position(point.p), normal(point.ng), shading_normal(point.ns);
  const LaneRows<L, Vec2> uv(point.uv);
  for (int lane = 0; lane < count; ++lane) {
    const int k = at + lane;
    if (packet.shape[k] == kNone) continue;
    const std::size_t i = first + static_cast<std::size_t>(lane);
    hits.distance[i] = packet.t_far[k];
    hits.position[i] = Vec3d(position[lane]) + scene.origin;
    hits.normal[i] = normal[lane];
    hits.shading_normal[i] = shading_normal[lane];
    hits.uv[2 * i] = uv[lane].x;
    hits.uv[2 * i + 1] = uv[lane].y;
    const ShapeRow& row = scene.geometry.shapes[packet.shape[k]];
    if (row.kind == static_cast<std::uint32_t>(ShapeKind::kMesh)) {
      hits.barycentric[2 * i] = packet.u[k];
      hits.barycentric[2 * i + 1] = packet.v[k];
    }
    hits.shape[i] = packet.shape[k];
    hits.primitive[i] = packet.primitive[k];
    hits.instance[i] = packet.instance[k];
  }
}

}  // namespace

RayHits trace_rays(const SceneView& scene, const std::vector<Vec3d>& origins, const std::vector<Vec3f>& directions) {
  RayHits hits = make_hits(origins.size());
  for (std::size_t first = 0; first < origins.size(); first += kPacketWidth) {
    const int count = static_cast<int>(std::min<std::size_t>(origins.size() - first, kPacketWidth));
    // Trace a packet
    RayPacket packet;
    for (int i = 0; i < kPacketWidth; ++i) {
      const std::size_t ray = first + static_cast<std::size_t>(std::min(i, count - 1));
      packet.set_ray(i, (origins[ray] - scene.origin).rounded(), directions[ray]);
      packet.shape[i] = kNone;
      packet.time[i] = 0;
    }
    scene.accel->intersect(packet, count);
    // Compute the surface points
    for (int at = 0; at < count; at += kWidth)
      store_tile(scene, packet, at, std::min(count - at, kWidth), first + static_cast<std::size_t>(at), hits);
  }
  return hits;
}

}  // namespace sheaf

// Traces single rays through a compiled scene.
#pragma once

#include "scene/accel/accel.h"
#include "scene/surfaces/shape.h"

#include <optional>

namespace sheaf {

/// The intersection of a ray with the scene.
struct TracedHit {
  float t, u, v;
  std::uint32_t primitive, shape, instance;
};

/// The nearest hit with t in (t_near, t_far).
inline std::optional<TracedHit> trace_ray(const SceneView& scene, Vec3f origin, Vec3f direction, float t_near = 0,
                                          float t_far = kInfinity) {
  RayPacket packet;
  packet.set_ray(0, origin, direction, t_far);
  packet.t_near[0] = t_near;
  packet.shape[0] = kNone;
  scene.accel->intersect(packet, 1);
  if (packet.shape[0] == kNone) return std::nullopt;
  return TracedHit{packet.t_far[0], packet.u[0], packet.v[0], packet.primitive[0], packet.shape[0], packet.instance[0]};
}

/// The surface at a hit of trace_ray().
inline SurfacePoint<Scalar> surface_at(const SceneView& scene, Vec3f origin, Vec3f direction, const TracedHit& hit) {
  const auto shape = gather_rows<Scalar>(scene.geometry.shapes, hit.shape);
  return surface_point<Scalar, true>(scene, shape, hit.primitive, hit.u, hit.v, origin + direction * hit.t,
                                     hit.instance, 0.0f);
}

}  // namespace sheaf

#include "scene/accel/near_query.h"

namespace sheaf {

void look_along(RTCScene scene, NearQuery& query, float radius) {
  // Embree ignores hits closer than twice the radius of a point or curve, to avoid self-intersection.
  const float ahead = 2.1f * radius, margin = 0.01f * radius;
  const Vec3f start = query.origin - query.direction * ahead;
  RTCRay ray{};
  ray.org_x = start.x, ray.org_y = start.y, ray.org_z = start.z;
  ray.dir_x = query.direction.x, ray.dir_y = query.direction.y, ray.dir_z = query.direction.z;
  ray.tfar = ahead + query.length + margin;
  ray.mask = 0xffffffffu;
#if SHEAF_EMBREE_MAJOR >= 4
  rtcInitRayQueryContext(&query.context);
  RTCOccludedArguments args;
  rtcInitOccludedArguments(&args);
  args.context = &query.context;
  rtcOccluded1(scene, &ray, &args);
#else
  rtcInitIntersectContext(&query.context);
  rtcOccluded1(scene, &query.context, &ray);
#endif
}

}  // namespace sheaf

// Queries for everything near a ray: a ray through Embree whose filter records each hit and rejects it, so that the ray
// continues.
#pragma once

#include "core/math/vec.h"
#include "scene/accel/embree.h"

namespace sheaf {

#if SHEAF_EMBREE_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
#else
using QueryContext = RTCIntersectContext;
#endif

/// A query along one ray. Embree passes the context to the filter.
struct NearQuery {
  QueryContext context;
  Vec3f origin, direction;
  float length;
};

/// Runs the filter of the scene's geometry for everything closer to the ray than `radius`.
void look_along(RTCScene scene, NearQuery& query, float radius);

}  // namespace sheaf

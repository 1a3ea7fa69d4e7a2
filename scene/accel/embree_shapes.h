// Embree's geometries of the scene's shapes: meshes, quadrics, SDF grids and curves.
#pragma once

#include "scene/accel/accel.h"
#include "scene/accel/embree.h"
#include "scene/accel/sdf_grid.h"

#include <deque>

namespace sheaf {

/// Geometry of shape `i`. Views of SDF grids are appended to `grids`; Embree holds pointers to them.
RTCGeometry make_embree_shape(RTCDevice device, const AccelInput& in, std::uint32_t i, std::deque<SdfGridView>& grids);

}  // namespace sheaf

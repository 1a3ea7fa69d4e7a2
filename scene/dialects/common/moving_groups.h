// Placement of instances, and shapes that move inside of shape groups.
#pragma once

#include "scene/description.h"
#include "scene/description/error_sink.h"
#include "scene/description/placement.h"

namespace sheaf {

/// The rows of the 3x4 matrix, as InstanceDescription::to_world.
std::array<double, 12> rows_of(const Transform& transform);

/// Whether an instance may be placed like this: is_usable_instance() holds at each key.
bool is_usable_placement(const Placement& placement);

/// Moves shapes with a motion from their groups to groups of their own, whose instances have that motion first. So the
/// shapes of all groups are at rest. Throws SceneError if the product of both is singular or too extreme; if `lenient`,
/// drops such instances and reports it.
void separate_moving_shapes(Description& description, ErrorSink& errors);

}  // namespace sheaf

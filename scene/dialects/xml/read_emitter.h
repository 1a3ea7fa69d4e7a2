// Reading of emitters, shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/lights/list.h"
#include "scene/xml/find_plugin.h"

namespace sheaf {

/// Reads an <emitter> inside a shape: `area` (also named after the shape, as `parallelogram_emitter`) or
/// `directionalarea`, with `radiance` (default 1). Reports an emitter that cannot be read, and leaves it out.
/// `ignored`: properties that are accepted without effect.
void find_area_emitter(const XmlElement& element, ReadContext& context, ShapeDescription& shape,
                       std::initializer_list<const char*> ignored = {});

/// Sets the motion of a light that was read from `p`, if its property named `to_world` is an <animation>.
void read_light_motion(Properties& p, const char* to_world, LightDescription& light);

/// Reads `direction` (default +z), or transforms +z by the property named `to_world`. Throws SceneError if both are
/// present; reports a zero vector.
Vec3f read_direction(Properties& p, const char* to_world);

/// The vector; +z if it is zero, with a report at the property.
Vec3f checked_direction(Properties& p, const char* name, Vec3f direction);

}  // namespace sheaf

// Reading of emitters, shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads an emitter that is not attached to a shape and has the same syntax in both dialects. Returns false for another
/// type. Throws SceneError.
bool read_shared_emitter(Properties& p, LightDescription& light);

/// Types that read_shared_emitter() supports.
const std::vector<std::string>& shared_emitter_names();

/// Reads an <emitter> inside a shape: `area` (also named after the shape, as `parallelogram_emitter`) or
/// `directionalarea`, with `radiance` (default 1). `ignored`: properties that are accepted without effect. Throws
/// SceneError.
void read_area_emitter(const XmlElement& element, ReadContext& context, ShapeDescription& shape,
                       std::initializer_list<const char*> ignored = {});

/// Reads `direction` (default +z), or transforms +z by the property named `to_world`. Throws SceneError if both are
/// present, and for a zero vector.
Vec3f read_direction(Properties& p, const char* to_world);

/// Throws SceneError at the property if the vector is zero.
void check_direction(Properties& p, const char* name, Vec3f direction);

}  // namespace sheaf

// What the dialects share in reading emitters.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads an emitter that stands for itself and that both dialects spell alike. Returns false for another type. Throws
/// SceneError.
bool read_shared_emitter(Properties& p, LightDescription& light);

/// The types of those.
const std::vector<std::string>& shared_emitter_names();

/// An <emitter> in a shape, which must be an `area` (or called after the shape, `parallelogram_emitter`) or a
/// `directionalarea`: `radiance` (1). `ignored`: properties that
/// may be there and mean nothing. Throws SceneError.
void read_area_emitter(const XmlElement& element, ReadContext& context, ShapeDescription& shape,
                       std::initializer_list<const char*> ignored = {});

/// `direction` (+z), or what the transform makes of +z; `to_world` is its name as the dialect spells it. Throws
/// SceneError where both are there, and for a direction without length.
Vec3f read_direction(Properties& p, const char* to_world);

/// Throws SceneError at the property if the vector has no length.
void check_direction(Properties& p, const char* name, Vec3f direction);

}  // namespace sheaf

// Shape groups and instances, shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/xml/properties.h"

#include <functional>

namespace sheaf {

/// Appends the shape of an element to the description.
using ShapeReader = std::function<void(const XmlElement&)>;

/// Reads an element that is a shape group or an instance and returns true; returns false for other elements.
/// `read_shape` is the shape reader of the dialect. Throws SceneError, also for nested groups or instances.
bool read_instancing(const XmlElement& element, ReadContext& context, const ShapeReader& read_shape);

}  // namespace sheaf

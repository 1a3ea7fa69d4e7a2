// Readers of the scene dialects. Each converts an expanded XML tree, or the text of a pbrt file, to a Description.
#pragma once

#include "scene/xml/properties.h"

#include <functional>

namespace sheaf {

/// Reads a Nori scene into context.description. Throws SceneError.
void read_nori(ReadContext& context);

/// Reads a Mitsuba scene (0.6, 2, 3) into context.description. Throws SceneError.
void read_mitsuba(ReadContext& context);

/// Reads a pbrt-v4 scene file. If `lenient`, substitutes or drops unsupported features. Throws SceneError.
void read_pbrt(const std::filesystem::path& file, Description& description, bool lenient);

/// Appends the shape of an element to the description.
using ShapeReader = std::function<void(const XmlElement&)>;
/// Reads an element that is a shape group or an instance and returns true; returns false for other elements.
/// `read_shape` is the shape reader of the dialect. Throws SceneError, also for nested groups or instances.
bool read_instancing(const XmlElement& element, ReadContext& context, const ShapeReader& read_shape);

/// Maximum number of samples per pixel that a scene may request.
inline constexpr int kMaxSampleCount = 1 << 24;
/// Throws SceneError at `where` if the frame has more than 10^9 pixels.
void check_frame(int width, int height, const SourceLocation& where);

}  // namespace sheaf

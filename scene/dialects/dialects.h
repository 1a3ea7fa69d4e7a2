// The dialects of scene files, each one function to a Description, from an expanded XML tree or from pbrt's text.
#pragma once

#include "scene/xml/properties.h"

#include <functional>

namespace sheaf {

/// Reads a Nori scene into context.description. Throws SceneError.
void read_nori(ReadContext& context);

/// Reads a Mitsuba scene (0.6, 2, 3) into context.description. Throws SceneError.
void read_mitsuba(ReadContext& context);

/// Reads a pbrt-v4 scene file. `lenient`: what is not supported becomes a note. Throws SceneError.
void read_pbrt(const std::filesystem::path& file, Description& description, bool lenient);

/// Appends the shape that an element describes to the description.
using ShapeReader = std::function<void(const XmlElement&)>;
/// Reads an element that is a shape group or an instance of one and returns true; returns false for other elements.
/// `read_shape` is the dialect's reader. Throws SceneError, also where groups or instances are nested.
bool read_instancing(const XmlElement& element, ReadContext& context, const ShapeReader& read_shape);

/// Appends a material, returns its index.
MaterialId add_material(ReadContext& context, MaterialDescription material);

/// Largest number of samples per pixel that a scene may ask for.
inline constexpr int kMaxSampleCount = 1 << 24;
/// Throws SceneError at `where` if the frame is larger than 10^9 pixels.
void check_frame(int width, int height, const SourceLocation& where);

}  // namespace sheaf

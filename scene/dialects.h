// The dialects of scene files, each one function from an expanded XML tree to a Description.
#pragma once

#include "scene/properties.h"

namespace sheaf {

/// Reads a Nori scene into context.description. Throws SceneError.
void read_nori(ReadContext& context);

/// Reads a Mitsuba scene (0.6, 2, 3) into context.description. Throws SceneError.
void read_mitsuba(ReadContext& context);

/// Appends a material, returns its index.
MaterialId add_material(ReadContext& context, MaterialDescription material);

/// Largest number of samples per pixel that a scene may ask for.
inline constexpr int kMaxSampleCount = 1 << 24;
/// Throws SceneError at `where` if the frame is larger than 10^9 pixels.
void check_frame(int width, int height, const SourceLocation& where);

}  // namespace sheaf

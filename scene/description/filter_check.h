// How wide a reconstruction filter may be.
#pragma once

#include "core/error.h"

namespace sheaf {

/// Pixels. Every sample is added to all pixels that its filter reaches.
inline constexpr double kMaxFilterRadius = 64;

/// Throws SceneError at `where` unless the radius, in pixels, is above zero and at most kMaxFilterRadius.
void check_filter_radius(double radius, const SourceLocation& where);

}  // namespace sheaf

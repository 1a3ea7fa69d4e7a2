// Limits on the radius of the pixel filter.
#pragma once

#include "core/error.h"

namespace sheaf {

/// Maximum radius, in pixels. Every sample is added to all pixels within its filter's radius.
inline constexpr double kMaxFilterRadius = 64;

/// Throws SceneError at `where` unless the radius, in pixels, is positive and at most kMaxFilterRadius.
void check_filter_radius(double radius, const SourceLocation& where);

}  // namespace sheaf

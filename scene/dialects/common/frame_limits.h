// Limits of frame size and sample count, common to all dialects.
#pragma once

#include "core/io/error.h"

namespace sheaf {

/// Maximum number of samples per pixel that a scene may request.
inline constexpr int kMaxSampleCount = 1 << 24;

/// Throws SceneError at `where` if the frame has more than 10^9 pixels.
void check_frame(int width, int height, const SourceLocation& where);

}  // namespace sheaf

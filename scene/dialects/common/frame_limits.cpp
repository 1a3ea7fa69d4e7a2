// Limit of the frame size.
#include "scene/dialects/common/frame_limits.h"

#include <cstdint>

namespace sheaf {

void check_frame(int width, int height, const SourceLocation& where) {
  constexpr std::int64_t kMaxPixels = 1'000'000'000;
  if (std::int64_t{width} * height > kMaxPixels)
    throw SceneError(where, fmt::format("the image has {} x {} pixels, expected at most 10^9", width, height));
}

}  // namespace sheaf

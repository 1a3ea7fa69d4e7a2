// The view of a scene without a camera.
#pragma once

namespace sheaf {

/// View direction for automatic camera placement.
struct ModelView {
  enum class Up { kX, kY, kZ } up = Up::kY;
  float azimuth = 30;    ///< degrees around the up axis
  float elevation = 20;  ///< degrees above the floor, in [-90, 90]
  float fov = 35;        ///< degrees along the image's shorter side, in (0, 180)
};

}  // namespace sheaf

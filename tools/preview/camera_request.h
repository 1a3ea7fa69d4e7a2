// Requests of the preview page: how the hand moves the camera. They come from the network, so that they are parsed
// strictly.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace sheaf {

/// Maximum size of a request's body, bytes.
inline constexpr std::size_t kMaxCameraRequest = 512;

/// A position on the image: from the upper left corner (0, 0) to (1, 1).
struct ImagePosition {
  double x = 0, y = 0;
};

/// A motion of the camera; see OrbitCamera. All members apply, in this order.
struct CameraRequest {
  bool reset = false;  ///< return to the camera of the file
  std::array<double, 2> orbit{}, pan{};
  double dolly = 0;
  std::optional<ImagePosition> target, focus;  ///< the point that is seen there
};

/// Parses a request: a JSON object with at least one of the members "reset": true, "orbit": [x, y], "pan": [x, y],
/// "dolly": steps, "target": [x, y] and "focus": [x, y]. Returns nothing for anything else, and for numbers out of
/// range.
std::optional<CameraRequest> parse_camera_request(std::string_view body);

/// Parses the two numbers of a position, as text. Returns nothing if it is malformed or outside of the image.
std::optional<ImagePosition> parse_image_position(std::string_view x, std::string_view y);

}  // namespace sheaf

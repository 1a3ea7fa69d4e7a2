#include "scene/description/field_of_view.h"

#include <cmath>
#include <string>

namespace sheaf {

double half_width_of(float fov, CameraDescription::FovAxis axis, double width, double height,
                     const SourceLocation& where) {
  if (!(fov > 0.0f && fov < 180.0f))
    throw SceneError(where, fmt::format("field of view must lie between 0 and 180 degrees, found {}", fov));
  const double t = std::tan(0.5 * fov * (3.14159265358979323846 / 180.0));
  using Axis = CameraDescription::FovAxis;
  switch (axis) {
    case Axis::kX:
      return t;
    case Axis::kY:
      return t * width / height;
    case Axis::kDiagonal:
      return t * width / std::hypot(width, height);
    case Axis::kSmaller:
      return width <= height ? t : t * width / height;
    case Axis::kLarger:
      return width >= height ? t : t * width / height;
  }
  return t;
}

}  // namespace sheaf

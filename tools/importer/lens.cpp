#include "tools/importer/lens.h"

#include <fmt/format.h>

#include <cmath>

namespace sheaf::importer {

void set_perspective(Camera& camera, const Lens& lens) {
  camera.is_perspective = true;
  camera.aspect = lens.x && lens.y && lens.aspect == 0 ? *lens.x / *lens.y : lens.aspect;
  // glTF has no horizontal field of view: without an aspect, it is that of a square image.
  if (lens.x && camera.aspect == 0) camera.aspect = 1;
  const double vertical = lens.y.value_or(lens.x ? *lens.x / camera.aspect : 0);
  camera.yfov = 2 * std::atan(vertical);
}

void set_orthographic(Camera& camera, std::optional<double> xmag, std::optional<double> ymag, double aspect) {
  camera.is_perspective = false;
  const double ratio = aspect > 0 ? aspect : 1;
  camera.xmag = xmag.value_or(ymag.value_or(0) * ratio);
  camera.ymag = ymag.value_or(xmag.value_or(0) / ratio);
}

void add_valid(Camera camera, NodeParts& to, std::vector<std::string>& notes) {
  const auto is_positive = [](double value) { return value > 0 && std::isfinite(value); };
  const bool shows = camera.is_perspective ? is_positive(camera.yfov) && camera.yfov < 3.14159
                                           : is_positive(camera.xmag) && is_positive(camera.ymag);
  if (shows && camera.aspect >= 0 && std::isfinite(camera.aspect)) {
    to.cameras.push_back(std::move(camera));
    return;
  }
  notes.push_back(fmt::format("camera '{}' has no field of view (ignored)", camera.name));
}

}  // namespace sheaf::importer

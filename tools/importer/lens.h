// Lenses of imported cameras: fields of view by any two of three numbers.
#pragma once

#include "tools/importer/parts.h"

#include <optional>

namespace sheaf::importer {

/// Tangents of half the horizontal and half the vertical field of view, and the width over the height of the image (0:
/// unknown).
struct Lens {
  std::optional<double> x, y;
  double aspect = 0;
};

/// Sets a perspective. Without a field of view, yfov becomes 0, which add_valid() rejects.
void set_perspective(Camera& camera, const Lens& lens);

/// Sets an orthographic view by half of its width, half of its height, or both.
void set_orthographic(Camera& camera, std::optional<double> xmag, std::optional<double> ymag, double aspect);

/// Adds a camera to its node, or a note if it shows nothing; the model is then seen by another camera.
void add_valid(Camera camera, NodeParts& to, std::vector<std::string>& notes);

}  // namespace sheaf::importer

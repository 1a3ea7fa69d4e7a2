// A photo studio around a bare model: a seamless backdrop and three area lights.
#pragma once

#include "scene/dialects/model/framing.h"

namespace sheaf {

/// Adds what stands around a framed model:
/// - a cyclorama, a floor that curves up into a wall behind the model. It covers the field of view of the camera.
/// - a key light on the left, a fill light on the right and a rim light behind, all outside the field of view. They are
///   as large as the model and light it in the same way at any size.
/// - dim light from everywhere else
/// The names of all begin with kStudioPrefix.
void add_soft_studio(const ModelFrame& frame, Description& description);

}  // namespace sheaf

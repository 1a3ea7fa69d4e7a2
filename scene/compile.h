// From what a file says to what kernels read.
#pragma once

#include "scene/scene.h"

namespace sheaf {

/// Compiles a description: loads meshes, flattens materials, makes light tables and builds the acceleration
/// structure. Throws SceneError for missing or broken assets. Degenerate geometry is left out with a warning.
std::unique_ptr<Scene> compile_scene(const Description& description);

}  // namespace sheaf

// From what a file says to what kernels read.
#pragma once

#include "scene/tables/scene.h"

namespace sheaf {

/// How a scene is compiled.
struct CompileOptions {
  /// Let no ray slip between two triangles that share an edge. Without it about one in two million does (measured on
  /// the Cornell box), and intersection of small scenes is up to half again as fast.
  bool watertight = false;
  ColorMode color = ColorMode::kRgb;
};

/// Compiles a description: loads meshes, flattens materials, makes light tables and builds the acceleration
/// structure. Throws SceneError for missing or broken assets. Degenerate geometry is left out with a warning.
std::unique_ptr<Scene> compile_scene(const Description& description, const CompileOptions& options = {});

/// The same, but what cannot be compiled is left out of the description, or replaced in it, and Description::stand_ins
/// says so. Throws SceneError for what is wrong with the scene as a whole.
std::unique_ptr<Scene> compile_leniently(Description& description, const CompileOptions& options = {});

}  // namespace sheaf

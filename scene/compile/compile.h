// From what a file says to what kernels read.
#pragma once

#include "scene/tables/scene.h"

namespace sheaf {

/// A grid where it lies.
struct PlacedGrid {
  std::string name;           ///< its file and the grid's name in it, as far as it has them
  SourceLocation where;       ///< what holds it
  GridBox box{};              ///< around its voxels; world space, metres
  std::array<int, 3> size{};  ///< voxels along each axis of its own; 0: it is empty
  int channels = 1;
  std::size_t bytes = 0;
};

/// What a scene's memory is taken by, for people.
struct CompileReport {
  std::vector<PlacedGrid> grids;  ///< of media and textures
  /// Environment map: nodes, and bytes of its tables; nothing where there is none.
  std::uint32_t envmap_width = 0, envmap_height = 0;
  std::size_t envmap_bytes = 0;
  std::size_t texture_bytes = 0;  ///< texels
};

/// How a scene is compiled.
struct CompileOptions {
  /// Let no ray slip between two triangles that share an edge. Without it about one in two million does (measured on
  /// the Cornell box), and intersection of small scenes is up to half again as fast.
  bool watertight = false;
  ColorMode color = ColorMode::kRgb;
  CompileReport* report = nullptr;  ///< where to put what is found; null: nowhere
};

/// Compiles a description: loads meshes, flattens materials, makes light tables and builds the acceleration
/// structure. Throws SceneError for missing or broken assets. Degenerate geometry is left out with a warning.
std::unique_ptr<Scene> compile_scene(const Description& description, const CompileOptions& options = {});

/// The same, but what cannot be compiled is left out of the description, or replaced in it, and Description::stand_ins
/// says so. Throws SceneError for what is wrong with the scene as a whole.
std::unique_ptr<Scene> compile_leniently(Description& description, const CompileOptions& options = {});

}  // namespace sheaf

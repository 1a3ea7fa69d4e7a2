// Compiles a description into a scene for kernels.
#pragma once

#include "core/io/name_table.h"
#include "scene/description.h"
#include "scene/description/error_sink.h"
#include "scene/scene.h"

#include <functional>

namespace sheaf {

/// A volume grid with its position.
struct PlacedGrid {
  std::string name;           ///< the file, and the grid's name in it, if any
  SourceLocation where;       ///< location of its owner in the scene file
  Bounds3f box{};             ///< around its voxels; world space, meters
  std::array<int, 3> size{};  ///< voxels along each axis, without background; 0: the grid is empty
  int channels = 1;
  std::size_t bytes = 0;
};

/// Memory use of a compiled scene, for reports.
struct CompileReport {
  std::vector<PlacedGrid> grids;  ///< grids of media and textures
  /// Environment map: number of nodes, and bytes of its tables; 0 without one.
  std::uint32_t envmap_width = 0, envmap_height = 0;
  std::size_t envmap_bytes = 0;
  std::size_t texture_bytes = 0;  ///< texels
  /// Wall-clock time for images of textures, for meshes, which are read at the same time, and for the acceleration
  /// structure. Mip levels, which are computed beside lights and acceleration structure, count if these are faster.
  double texture_seconds = 0, mesh_seconds = 0, accel_seconds = 0;
};

/// Choice of the memory layout of the acceleration structure: by the user, or compact if kFast would not fit.
enum class BvhChoice { kAuto, kFast, kCompact };
inline constexpr NameTable<BvhChoice> kBvhChoices{
    {{"auto", BvhChoice::kAuto}, {"fast", BvhChoice::kFast}, {"compact", BvhChoice::kCompact}}};

struct KeptGeometry;

/// Options of scene compilation.
struct CompileOptions {
  /// Prevents rays from passing between two triangles that share an edge. Without it, about one ray in two million does
  /// (measured on the Cornell box), and intersection in small scenes is up to 50% faster.
  bool watertight = false;
  ColorMode color = ColorMode::kRgb;
  const SceneSettings* settings = nullptr;  ///< instead of those of the description; null: those
  CompileReport* report = nullptr;          ///< receives a report; null: none
  BvhChoice bvh = BvhChoice::kAuto;
  /// Upper estimate of the number of rays of the render, for BvhChoice::kAuto: few do not repay spatial splits,
  /// and fewer not even kFast.
  double expected_rays = kInfinity;
  /// Returns the memory that the render needs besides the scene, in bytes, for BvhChoice::kAuto. The scene lacks its
  /// acceleration structure. Empty: none.
  std::function<double(const Scene&)> render_bytes = {};
  /// Receives the errors of elements that cannot be compiled: textures become gray, materials diffuse and media empty;
  /// shapes and lights are left out. Null: as in strict mode.
  ErrorSink* errors = nullptr;
  /// Geometry of an earlier scene (scene/compile/geometry/kept_geometry.h), used instead of an equal one; null: none.
  KeptGeometry* kept = nullptr;
};

/// Compiles a description: loads meshes, flattens materials, builds light tables and the acceleration structure. Throws
/// SceneErrors for missing or broken assets, SceneError for errors that concern the whole scene. Degenerate geometry is
/// dropped with a warning.
std::unique_ptr<Scene> compile_scene(const Description& description, const CompileOptions& options = {});

}  // namespace sheaf

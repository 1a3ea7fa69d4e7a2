// The geometry of a scene while it is compiled, and the functions that add the shapes of each kind to it.
#pragma once

#include "core/math/bounds.h"
#include "scene/accel/accel.h"
#include "scene/compile/compile_motion.h"
#include "scene/compile/geometry/prepare_mesh.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/scene.h"

#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sheaf {

/// Where a row of the table of shapes comes from.
struct ShapeSource {
  const ShapeDescription* shape;
  const ShapeGroup* group;  ///< null: not part of a group of the description
};

/// A shape that bounds a medium.
struct BoundaryShape {
  std::uint32_t shape;  ///< row
  Bounds3f box;         ///< of a shape that moves: at the first key
};

/// An instance that moves.
struct MovingInstance {
  std::uint32_t instance;      ///< row
  std::array<float, 12> rest;  ///< transform that places the tables of its lights
};

/// Tables of geometry, and what the compilers of other subjects need to know about them.
struct CompiledGeometry {
  /// `attribute_names`: those of mesh attributes that textures use.
  explicit CompiledGeometry(const std::vector<std::string>& attribute_names) : attributes(attribute_names) {}

  GeometryTables tables;
  std::vector<ShapeSource> sources;              ///< by row of shapes
  std::uint32_t ungrouped_shapes = 0;            ///< number of shapes outside of groups; those of groups follow
  std::vector<ShapeRange> groups;                ///< none empty
  std::vector<BoundaryShape> boundaries;         ///< by row
  std::vector<MovingInstance> moving_instances;  ///< by row
  std::vector<std::uint32_t> vertex_counts;      ///< see AccelInput
  Bounds3f bounds = Bounds3f::empty();           ///< of all shapes outside of groups and of all instances
  SceneInfo info;                                ///< numbers of shapes of each kind, of instances and of groups
  AttributeTable attributes;
  std::set<std::string> known_attributes;  ///< of all meshes, used by textures or not
  std::vector<std::string> warnings;

  void warn(const ShapeDescription& shape, const std::string& message) {
    warnings.push_back(SceneError(shape.where, message).what());
  }
};

/// Words at the end of GeometryTables::triangles, which kernels load four at a time.
inline constexpr std::size_t kTrianglePadding = 8;

/// The row of a shape whose geometry has been added.
struct AddedShape {
  ShapeRow row;  ///< its geometry; without material, light and boundary
  Bounds3f box;  ///< at all times
  std::uint32_t vertex_count = 0;
};

/// Whether the squares of a box's coordinates and of its size are finite.
inline bool is_traceable(const Bounds3f& box) {
  constexpr float kLargest = 1e18f;
  return is_finite(box.max - box.min) && max_component(abs(box.max)) <= kLargest &&
         max_component(abs(box.min)) <= kLargest;
}

// Each function adds the geometry of a shape to `out`. Returns nothing, with a warning, for shapes that are degenerate.
// Throws SceneError for invalid ones, and for too many.

std::optional<AddedShape> add_mesh(const ShapeDescription& shape, const PreparedMesh& prepared, MotionCompiler& motion,
                                   CompiledGeometry& out);
std::optional<AddedShape> add_quadric(const ShapeDescription& shape, const QuadricRow& quadric, CompiledGeometry& out);
std::optional<AddedShape> add_curves(const ShapeDescription& shape, const Curves& curves, MotionCompiler& motion,
                                     CompiledGeometry& out);
std::optional<AddedShape> add_curves(const ShapeDescription& shape, const DeformingCurves& from, MotionCompiler& motion,
                                     CompiledGeometry& out);
std::optional<AddedShape> add_sdf_grid(const ShapeDescription& shape, const SdfGrid& grid, CompiledGeometry& out);

}  // namespace sheaf

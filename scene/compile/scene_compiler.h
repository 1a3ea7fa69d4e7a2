// What turns a description into a scene, for the files scene/compile*.cpp alone: each defines the members of a subject.
#pragma once

#include "scene/compile/compile.h"
#include "scene/compile/compile_textures.h"
#include "scene/compile/lights/area_light.h"
#include "scene/compile/scene_naming.h"
#include "scene/compile/spectra.h"
#include "scene/formats/mesh.h"

#include <algorithm>
#include <limits>
#include <set>

namespace sheaf {

/// Overload set for std::visit.
template <class... F> struct Overloaded : F... { using F::operator()...; };
template <class... F> Overloaded(F...) -> Overloaded<F...>;

/// Lets the box [lower, upper] hold another.
inline void grow_box(Vec3f& lower, Vec3f& upper, Vec3f to_lower, Vec3f to_upper) {
  lower = {std::min(lower.x, to_lower.x), std::min(lower.y, to_lower.y), std::min(lower.z, to_lower.z)};
  upper = {std::max(upper.x, to_upper.x), std::max(upper.y, to_upper.y), std::max(upper.z, to_upper.z)};
}

/// Whether squares of the coordinates of a box, and of its size, stay finite.
inline bool is_traceable(Vec3f lower, Vec3f upper) {
  constexpr float kLargest = 1e18f;
  return is_finite(upper - lower) && max_component(abs(upper)) <= kLargest && max_component(abs(lower)) <= kLargest;
}

/// Fills a Scene, table by table. Every step may throw SceneError.
class SceneCompiler {
 public:
  /// Both must outlive the compiler.
  SceneCompiler(const Description& description, const CompileOptions& options)
      : in_(description), options_(options), out_(std::make_unique<Scene>()), naming_(out_->names_) {}

  /// Takes all steps in their order. To be called once.
  std::unique_ptr<Scene> run();

 private:
  /// Vertices that kernels can address: byte-free word indices must fit 32 bits.
  static constexpr std::size_t kMaxWords = std::numeric_limits<std::uint32_t>::max() - 64;

  /// A shape that emits.
  struct Emitter {
    std::uint32_t shape;
    AreaEmission emission;
    SourceLocation where;
    std::string name;  ///< may be empty
  };

  /// What a group holds, for its instances.
  struct GroupContents {
    ShapeRange range;
    std::uint32_t index;  ///< among the groups that are not empty
    std::size_t triangles;
    Vec3f lower, upper;  ///< bounds in the group's space
    std::vector<Emitter> emitters;
  };

  // compile.cpp
  /// What makes rows of spectra; null in RGB mode.
  SpectrumSet* spectra() { return spectra_ ? &*spectra_ : nullptr; }
  void add_cameras();
  void add_materials();
  bool panes_can_be_open() const;
  /// Once all shapes and instances are there.
  void set_bounds();
  void finish_tables();
  /// What memory is taken by, once all tables are there.
  CompileReport report() const;
  void warn(const ShapeDescription& shape, const std::string& message);

  // compile_shapes.cpp
  void add_shape(const ShapeDescription& shape);
  /// The order of the steps is explained in scene/formats/mesh.h.
  /// `is_split`: as MeshFile has it.
  void add_mesh(ShapeRow row, const ShapeDescription& shape, Mesh mesh, bool face_normals, bool is_split = false);
  void add_quadric(ShapeRow row, const ShapeDescription& shape, const QuadricRow& quadric);
  /// Adds the row of a shape within `box`. If it emits, a light, which for shapes of groups waits for the instances.
  void push_shape(ShapeRow row, const ShapeDescription& shape, const GridBox& box);
  GroupContents add_group(const ShapeGroup& group);
  /// With the lights of each. `groups`: those of the description, in their order.
  void add_instances(const std::vector<GroupContents>& groups);
  /// Lets the bounds hold the box [lower, upper].
  void grow(Vec3f lower, Vec3f upper);

  // check_attributes.cpp
  /// Throws where a texture shows an attribute that no mesh with its material has; once all shapes are there.
  void check_attributes();

  // compile_curves.cpp
  void add_curves(ShapeRow row, const ShapeDescription& shape, const Curves& curves);

  // compile_sdf_grid.cpp
  void add_sdf_grid(ShapeRow row, const ShapeDescription& shape, const SdfGrid& grid);

  // compile_lights.cpp
  LightContext light_context();
  /// Those that are somewhere join the area lights, the others come last.
  void add_lights();
  /// Media that glow become lights, where lights are sampled and the estimator can weigh them.
  void add_volume_lights();
  void add_area_light(const ShapeRow& row, const Emitter& emitter, const InstanceRow* instance);
  /// Adds a light unless it is black. Throws where it stands for a second environment.
  void push_light(CompiledLight light, const LightDescription& from);
  /// `name`: may be empty.
  void add_light_row(const LightRow& row, const SpectrumRow& spectrum, const SourceLocation& where,
                     const std::string& name);
  /// What a shape emits, or nothing if that is black.
  std::optional<AreaEmission> emission_of(const ShapeDescription& shape);
  /// The tables that choose lights, once textures can be looked up.
  void select_lights();

  // compile_boundaries.cpp
  /// The medium on a side of a shape as BoundaryRow has it.
  std::uint32_t hold(std::optional<MediumId> medium, const ShapeDescription& shape, const GridBox& box);
  void add_media();
  /// Where what shines from outside enters the media that no surface ends; once the lights are there.
  void end_media();
  /// What only looking around can tell: media around shapes and around the camera.
  void probe_media();
  /// The same for scenes with boundaries; `default_value`: the medium where there is nothing around.
  void probe_boundaries(std::uint32_t default_value);
  /// The medium that the camera's rays start in; a warning where they start in several.
  void probe_camera();

  const Description& in_;
  const CompileOptions& options_;
  std::unique_ptr<Scene> out_;
  SceneNaming naming_;
  std::vector<std::uint32_t> row_of_material_;
  std::uint32_t default_material_ = 0;
  std::optional<SpectrumSet> spectra_;        ///< in spectral mode
  std::optional<AttributeTable> attributes_;  ///< once textures are known
  std::set<std::string> known_attributes_;    ///< that meshes have, whether or not a texture shows them
  std::vector<std::pair<std::uint32_t, std::uint32_t>> emission_textures_;  ///< shapes, and what they emit
  std::vector<std::uint32_t> vertex_counts_;
  std::vector<std::uint32_t> row_of_phase_;         ///< the last: isotropic
  std::vector<std::vector<GridBox>> medium_boxes_;  ///< around the shapes that hold each medium
  std::vector<PlacedGrid> places_of_grids_;         ///< of the grids of media
  std::vector<std::uint32_t> surrounded_shapes_;    ///< whose exterior is yet to be found
  std::uint32_t ungrouped_shapes_ = 0;
  std::vector<ShapeRange> group_ranges_;
  std::vector<Emitter>* group_emitters_ = nullptr;  ///< of the group whose shapes are being added
  std::string group_name_;                          ///< its name; may be empty
  Vec3f lower_{kInfinity, kInfinity, kInfinity}, upper_{-kInfinity, -kInfinity, -kInfinity};
};

}  // namespace sheaf

// The compiler from a description to a scene, for scene/compile/compile*.cpp only. Each file defines some members.
#pragma once

#include "scene/compile/compile.h"
#include "scene/compile/geometry/kept_geometry.h"
#include "scene/compile/geometry/open_boundaries.h"
#include "scene/compile/geometry/prepare_mesh.h"
#include "scene/compile/motion_steps.h"
#include "scene/compile/scene_naming.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/formats/mesh.h"
#include "scene/lights/area_light.h"
#include "scene/lights/light_context.h"
#include "scene/spectra/spectrum_set.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <set>
#include <span>

namespace sheaf {

/// Overload set for std::visit.
template <class... F> struct Overloaded : F... { using F::operator()...; };
template <class... F> Overloaded(F...) -> Overloaded<F...>;

/// Adds the time until its destruction, in seconds.
class SecondsTimer {
 public:
  explicit SecondsTimer(double& seconds) : seconds_(seconds) {}
  ~SecondsTimer() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  SecondsTimer(const SecondsTimer&) = delete;
  SecondsTimer& operator=(const SecondsTimer&) = delete;

 private:
  double& seconds_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Extends the box [lower, upper] to contain another box.
inline void grow_box(Vec3f& lower, Vec3f& upper, Vec3f to_lower, Vec3f to_upper) {
  lower = {std::min(lower.x, to_lower.x), std::min(lower.y, to_lower.y), std::min(lower.z, to_lower.z)};
  upper = {std::max(upper.x, to_upper.x), std::max(upper.y, to_upper.y), std::max(upper.z, to_upper.z)};
}

/// Whether the squares of a box's coordinates and of its size are finite.
inline bool is_traceable(Vec3f lower, Vec3f upper) {
  constexpr float kLargest = 1e18f;
  return is_finite(upper - lower) && max_component(abs(upper)) <= kLargest && max_component(abs(lower)) <= kLargest;
}

/// Fills a Scene, table by table. All steps may throw SceneError.
class SceneCompiler {
 public:
  /// `origin`: see moved_to(), which made the description. All arguments must outlive the compiler.
  SceneCompiler(const Description& description, Vec3d origin, const CompileOptions& options)
      : in_(description), options_(options), out_(std::make_unique<Scene>()), naming_(out_->names_) {
    out_->origin_ = origin;
  }

  /// Runs all steps in order. Call once. Starts again with another origin if mesh files lie far from the present one.
  std::unique_ptr<Scene> run();

  /// Moves the geometry out of a scene, which must not be used afterwards.
  static void keep_geometry(Scene& scene, KeptGeometry& kept);

 private:
  /// Maximum number of 32-bit words in a table, so that kernels can address them by 32-bit indices.
  static constexpr std::size_t kMaxWords = std::numeric_limits<std::uint32_t>::max() - 64;

  /// Words at the end of GeometryTables::triangles, which kernels load four at a time.
  static constexpr std::size_t kTrianglePadding = 8;

  /// A shape that emits light.
  struct Emitter {
    std::uint32_t shape;
    AreaEmission emission;
    SourceLocation where;
    std::string name;  ///< may be empty
  };

  /// The content of a group, for its instances.
  struct GroupContents {
    ShapeRange range;
    std::uint32_t index;  ///< index among the groups that are not empty
    std::size_t triangles;
    Vec3f lower, upper;  ///< bounds in the group's space
    std::vector<Emitter> emitters;
  };

  /// A shape that contains a medium.
  struct MediumShape {
    GridBox box;                      ///< its bounds; of a shape that moves, at the first key
    const AnimatedTransform* motion;  ///< null: the shape stands still
  };

  // compile.cpp
  /// Makes rows of spectra; null in RGB mode.
  SpectrumSet* spectra() { return spectra_ ? &*spectra_ : nullptr; }
  void add_cameras();
  void add_materials();
  bool shadow_rays_can_pass_thin_dielectrics() const;
  /// Call after all shapes and instances have been added.
  void set_bounds();
  /// The origin that suits the vertices of mesh files; zero if the present one does.
  Vec3d origin_of_mesh_files() const;
  /// Pads tables for kernels, and builds the tables that depend on all others.
  void finish_tables();
  /// Memory use; call after all tables are complete.
  CompileReport report() const;
  void warn(const ShapeDescription& shape, const std::string& message);

  // kept_geometry.cpp
  /// Builds the acceleration structure, or takes the kept one.
  void build_accel();
  /// The memory layout of the acceleration structure.
  BvhLayout choose_layout();

  // compile_shapes.cpp
  void add_shape(const ShapeDescription& shape);
  /// Starts reading the meshes of all shapes.
  void read_meshes_ahead();
  void add_mesh(ShapeRow row, const ShapeDescription& shape, PreparedMesh prepared);
  /// Adds the later steps of a mesh that deforms, whose first step has just been added.
  void add_mesh_steps(ShapeRow& row, const Mesh& mesh, const std::vector<MeshStep>& later);
  /// Adds the row of a shape that deforms to the tables of motion. `vertex_count`: of each step.
  void add_deformation(ShapeRow& row, std::size_t segment_count, std::size_t vertex_count);
  /// Adds the attributes that textures use of a mesh that becomes the next shape.
  void add_attributes(const ShapeRow& row, const Mesh& mesh, const SourceLocation& where);
  void add_quadric(ShapeRow row, const ShapeDescription& shape, const QuadricRow& quadric);
  /// Adds the row of a shape with bounding box `box`, and its light if it emits. In groups, the instances add the
  /// lights.
  void push_shape(ShapeRow row, const ShapeDescription& shape, const GridBox& box);
  /// `name`: of the group; may be empty.
  GroupContents add_group(std::span<const ShapeDescription> shapes, const std::string& name);
  /// Includes the lights of each instance. `groups`: those of the description, in order.
  void add_instances(const std::vector<GroupContents>& groups);
  /// Extends the scene's bounds to contain the box [lower, upper].
  void grow(Vec3f lower, Vec3f upper);

  // check_attributes.cpp
  /// Throws if a texture uses an attribute that no mesh with its material has. Call after all shapes have been added.
  void check_attributes();

  // compile_curves.cpp
  /// The control points of curves at one time, in world space.
  using CurveStep = std::vector<CurvePointRow>;
  void add_curves(ShapeRow row, const ShapeDescription& shape, const Curves& curves);
  void add_curves(ShapeRow row, const ShapeDescription& shape, const DeformingCurves& from);
  /// Adds curves at equidistant times over the shutter. `keys`: the same at all times at which they are given.
  void add_curve_steps(ShapeRow row, const ShapeDescription& shape, const Curves& curves,
                       const std::vector<CurveStep>& keys, const std::vector<CurveStep>& steps);

  // compile_sdf_grid.cpp
  void add_sdf_grid(ShapeRow row, const ShapeDescription& shape, const SdfGrid& grid);

  // compile_motion.cpp
  /// Whether the shutter is open long enough for anything to move.
  bool moves() const { return in_.shutter.close > in_.shutter.open; }
  const AnimatedTransform& motion_of(MotionId id) const { return in_.motions.at(static_cast<std::size_t>(id)); }
  /// Appends steps to the tables.
  MotionRow add_motion(const std::vector<MotionStepRow>& steps);
  /// Whether a shape has a motion, which places it as an instance.
  static bool is_placed_by_motion(const ShapeDescription& shape) { return shape.motion.has_value(); }
  /// Adds the shapes that have a motion, each as a group with one instance.
  void add_moving_shapes();
  /// Adds an instance of a group that moves. `rest`: transform that places the lights' tables.
  void add_moving_instance(const GroupContents& group, const Motion& motion, const Transform& rest);
  /// Adds a motion to all lights from row `first` on.
  void add_light_motion(std::size_t first, const MotionRow& row);
  /// Adds the motion of a light that is not on a shape, the last row. Call after the bounds are known.
  void move_last_light(MotionId id);
  /// The camera as it is when the shutter opens. Adds its motion from there.
  CameraDescription place_camera(CameraDescription camera, std::size_t index);
  /// Where the tables place a point, and where it is at each step of its motion.
  std::vector<Vec3f> places_along(const MotionRow& motion, Vec3f p) const;
  /// Adds the motion of an object from the first key, where its tables place it. Returns a row without segments if it
  /// is always there.
  MotionRow add_motion_from_rest(const AnimatedTransform& motion, const MotionProbes& probes);
  /// A row with the transform of a step.
  InstanceRow step_placement(std::uint32_t step) const;
  /// Bounds of a light at all steps of its motion.
  LightBounds moved_bounds(LightBounds bounds, std::size_t light) const;
  /// Extends the tables of motions to all instances, lights and cameras.
  void finish_motion();

  // compile_medium_motion.cpp
  /// The motion of the grids of a medium; null: they stand still. A medium without grids that emits moves with its
  /// shapes if all of them move alike. Throws SceneError if grids move in different ways.
  const AnimatedTransform* motion_of_medium(std::size_t medium) const;
  /// Where the grids of a medium are, in world space at the first key: the box around them.
  GridBox box_of_grids(std::size_t medium) const;
  /// Outside of this box, in world space at the first key, the medium has no extinction. Nothing if it has no bounds.
  std::optional<GridBox> box_of_extinction(std::size_t medium) const;
  /// The boxes of a medium's shapes relative to its grids, at any time while the shutter is open.
  std::vector<GridBox> boxes_at_rest(std::size_t medium, const AnimatedTransform* motion) const;
  /// Adds the motions of all media. Call after their grids have been compiled.
  void move_media();

  // compile_lights.cpp
  LightContext light_context();
  /// Bounded lights follow the area lights; lights at infinity come last.
  void add_lights();
  /// Makes lights of emitting media if lights are sampled and the estimator supports it.
  void add_volume_lights();
  void add_area_light(const ShapeRow& row, const Emitter& emitter, const LightInstance* instance);
  /// Adds a light unless it is black. Throws for a second environment light.
  void push_light(const CompiledLight& light, const LightDescription& from);
  /// `name`: may be empty.
  void add_light_row(const LightRow& row, const SpectrumRow& spectrum, const SourceLocation& where,
                     const std::string& name);
  /// Emission of a shape; empty if it is black.
  std::optional<AreaEmission> emission_of(const ShapeDescription& shape);
  /// The clearcoat over a shape's emission.
  LightCoatRow coat_of(const ShapeDescription& shape);
  /// The texture of a shape's emission, if it emits by one.
  static std::optional<TextureId> emission_texture_of(const ShapeDescription& shape);
  /// Builds the tables for light selection. Textures must be available.
  void select_lights();

  // compile_boundaries.cpp
  /// The medium on a side of a shape, encoded as in BoundaryRow.
  std::uint32_t hold(std::optional<MediumId> medium, const ShapeDescription& shape, const GridBox& box);
  void add_media();
  /// Sets the radius at which unbounded media end for lights at infinity. Call after the lights have been added.
  void end_media();
  /// Finds the media around shapes and around the camera by probe rays.
  void probe_media();
  /// The same for scenes with boundaries. `default_value`: the medium outside of all shapes.
  void probe_boundaries(std::uint32_t default_value);
  /// Whether a shape that bounds a medium moves or deforms.
  bool boundaries_move() const;
  /// Finds the media around the shapes that do not name theirs, for each of their instances and over the shutter.
  void probe_surroundings(std::uint32_t default_value);
  /// Finds the media in which the rays of each camera start, over the shutter.
  void probe_cameras(std::uint32_t default_value);
  /// Warns if the rays of a camera start in several media when the shutter opens. `width`, `height`: of its part of the
  /// film. `middle`: where the central ray starts.
  void warn_of_camera_media(const Camera& camera, const SourceLocation& where, float width, float height, Vec3f middle,
                            std::uint32_t default_value);

  const Description& in_;
  const CompileOptions& options_;
  std::unique_ptr<Scene> out_;
  SceneNaming naming_;
  OpenBoundaries open_boundaries_;
  std::optional<ReadAhead<PreparedMesh>> meshes_;  ///< in the order of add_shape()
  std::size_t next_mesh_ = 0;                      ///< among them
  CompileReport times_;                            ///< only its times
  std::vector<std::uint32_t> row_of_material_;
  std::uint32_t default_material_ = 0;
  std::optional<SpectrumSet> spectra_;        ///< in spectral mode
  std::optional<AttributeTable> attributes_;  ///< set after the textures
  std::set<std::string> known_attributes_;    ///< of all meshes, used by textures or not
  /// shapes with textured emission, and its texture
  std::vector<std::pair<std::uint32_t, std::uint32_t>> emission_textures_;
  std::vector<std::uint32_t> vertex_counts_;
  std::vector<std::uint32_t> row_of_phase_;              ///< the last one is isotropic
  std::vector<std::vector<MediumShape>> medium_shapes_;  ///< the shapes that contain each medium
  std::vector<std::vector<GridBox>> medium_boxes_;       ///< their bounds, relative to the grids of the medium
  std::vector<MotionRow> medium_motions_;                ///< of each medium, with or without grids
  std::vector<PlacedGrid> places_of_grids_;              ///< grids of media
  std::vector<PlacedGrid> places_of_texture_grids_;
  std::vector<std::uint32_t> surrounded_shapes_;  ///< shapes whose exterior medium must be found
  std::vector<const ShapeDescription*> moving_shapes_;
  const AnimatedTransform* shape_motion_ = nullptr;  ///< motion of the shape that is being added as a group
  std::vector<CameraDescription> cameras_;           ///< when the shutter opens
  std::uint32_t ungrouped_shapes_ = 0;
  std::vector<ShapeRange> group_ranges_;
  std::vector<Emitter>* group_emitters_ = nullptr;  ///< emitters of the group whose shapes are being added
  std::string group_name_;                          ///< name of that group; may be empty
  Vec3f lower_{kInfinity, kInfinity, kInfinity}, upper_{-kInfinity, -kInfinity, -kInfinity};
};

}  // namespace sheaf

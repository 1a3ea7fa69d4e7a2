#include "scene/compile/geometry/compile_geometry.h"

#include "core/math/frame.h"
#include "scene/accel/quadric.h"
#include "scene/compile/geometry/sample_height_field.h"
#include "scene/compile/overloaded.h"

#include <span>

namespace sheaf {

namespace {

/// A canonical quadric with its transform.
struct CanonicalQuadric {
  ShapeKind kind;
  Transform to_world;
};

CanonicalQuadric canonical(const SphereShape& s, const Transform& t) {
  return {ShapeKind::kSphere, t * Transform::translate(s.center) * Transform::scale({s.radius, s.radius, s.radius})};
}
CanonicalQuadric canonical(const DiskShape&, const Transform& t) { return {ShapeKind::kDisk, t}; }
CanonicalQuadric canonical(const CylinderShape& c, const Transform& t) {
  const Vec3f axis = (c.p1 - c.p0).rounded();
  const float height = length(axis);
  if (!(height > 0.0f)) throw SceneError("the cylinder has zero length");
  const Frame<Scalar> frame = Frame<Scalar>::from_normal(axis / height);
  Matrix4 m;
  const Vec3d columns[4] = {frame.s * c.radius, frame.t * c.radius, c.p1 - c.p0, c.p0};
  for (std::size_t j = 0; j < 4; ++j) {
    m.m[0][j] = columns[j].x;
    m.m[1][j] = columns[j].y;
    m.m[2][j] = columns[j].z;
  }
  return {ShapeKind::kCylinder, t * Transform(m)};
}

template <class Shape>
concept IsQuadric = requires(const Shape& shape, const Transform& t) {
  canonical(shape, t);
};

/// Whether a shape is placed by a motion, as an instance.
bool is_placed_by_motion(const ShapeDescription& shape) { return shape.motion.has_value(); }

/// Adds shapes and instances to the tables, in order.
class GeometryCompiler {
 public:
  GeometryCompiler(const Description& description, MeshReader& meshes, const TextureTables& textures,
                   const CompiledMaterials& materials, MotionCompiler& motion, ErrorSink& errors)
      : in_(description),
        meshes_(meshes),
        textures_(textures),
        materials_(materials),
        motion_(motion),
        errors_(errors),
        out_(textures.attribute_names) {}

  CompiledGeometry run() {
    for (const ShapeDescription& shape : in_.shapes)
      if (!is_placed_by_motion(shape)) add_shape({&shape, nullptr}, out_.bounds);
    out_.ungrouped_shapes = static_cast<std::uint32_t>(out_.sources.size());
    std::vector<Group> groups;
    for (const ShapeGroup& group : in_.groups) groups.push_back(add_group(group.shapes, &group));
    add_instances(groups);
    add_moving_shapes();
    meshes_.finish();
    finish();
    return std::move(out_);
  }

 private:
  /// The contents of a group, for its instances.
  struct Group {
    ShapeRange range;
    std::uint32_t index;  ///< among CompiledGeometry::groups
    std::size_t triangles;
    Bounds3f bounds;  ///< in the group's space

    InstanceRow position(const std::array<float, 12>& to_world) const {
      return make_instance(to_world, range.first_shape, index);
    }
  };

  /// Adds a shape, and grows `bounds` to contain it.
  void add_shape(const ShapeSource& source, Bounds3f& bounds) {
    const ShapeDescription& shape = *source.shape;
    std::optional<AddedShape> added;
    try {
      added = add_geometry(shape);
    } catch (const SceneError& error) {
      omit(shape, error);
      out_.attributes.remove(static_cast<std::uint32_t>(out_.sources.size()));
    }
    if (!added) return;
    bounds.grow(added->box);
    ShapeRow& row = added->row;
    row.material =
        shape.material ? materials_.row_of.at(static_cast<std::size_t>(*shape.material)) : materials_.default_row;
    if (!shape.is_visible) row.flags |= kUntraced;
    if (shape.interior || shape.exterior)
      out_.boundaries.push_back({static_cast<std::uint32_t>(out_.sources.size()), added->box});
    out_.tables.shapes.push_back(row);
    out_.vertex_counts.push_back(added->vertex_count);
    out_.sources.push_back(source);
  }

  void omit(const ShapeDescription& shape, const SceneError& error) {
    errors_.report(at_location(shape.where, error), "shape left out");
  }

  std::optional<AddedShape> add_geometry(const ShapeDescription& shape) {
    if (has_prepared_mesh(shape)) return add_mesh(shape, meshes_.next());
    return std::visit(
        Overloaded{
            [&](const HeightFieldShape& field) {
              return add_mesh(shape, prepare_mesh(shape, sample_height_field(field, textures_), shape.face_normals));
            },
            [&](const Curves& curves) { return add_curves(shape, curves, motion_, out_); },
            [&](const DeformingCurves& curves) { return add_curves(shape, curves, motion_, out_); },
            [&](const SdfGrid& grid) { return add_sdf_grid(shape, grid, out_); },
            [&](const IsQuadric auto& quadric) {
              const CanonicalQuadric placed = canonical(quadric, shape.to_world);
              return add_quadric(shape, make_quadric(placed.kind, placed.to_world, shape.flip_normals), out_);
            },
            [](const auto& /*mesh*/) { return std::optional<AddedShape>(); },
        },
        shape.geometry);
  }

  std::optional<AddedShape> add_mesh(const ShapeDescription& shape, PreparedMesh prepared) {
    open_boundaries_.add(std::move(prepared.open_edges));
    return sheaf::add_mesh(shape, prepared, motion_, out_);
  }

  /// `from`: null for a shape that moves.
  Group add_group(std::span<const ShapeDescription> shapes, const ShapeGroup* from) {
    const std::size_t triangles = out_.info.triangles;
    const auto count = [&] { return static_cast<std::uint32_t>(out_.sources.size()); };
    Group group{{count(), 0}, static_cast<std::uint32_t>(out_.groups.size()), 0, Bounds3f::empty()};
    for (const ShapeDescription& shape : shapes) add_shape({&shape, from}, group.bounds);
    group.range.shape_count = count() - group.range.first_shape;
    group.triangles = out_.info.triangles - triangles;
    if (group.range.shape_count > 0) out_.groups.push_back(group.range);
    return group;
  }

  /// `groups`: those of the description, in order.
  void add_instances(const std::vector<Group>& groups) {
    out_.tables.instances.reserve(in_.instances.size());
    std::size_t too_large = 0;
    for (const InstanceDescription& instance : in_.instances) {
      const Group& group = groups.at(instance.group);
      if (group.range.shape_count == 0) continue;
      if (const AnimatedTransform* motion = motion_.transform(instance.motion)) {
        add_moving_instance(group, {*motion, {}}, motion->reference());
        continue;
      }
      const InstanceRow row = group.position(rounded_rows(instance.to_world));
      const Bounds3f bounds = instance_bounds(row, group.bounds);
      if (!is_traceable(bounds)) {
        ++too_large;
        continue;
      }
      out_.bounds.grow(bounds);
      push_instance(row, group);
    }
    if (too_large > 0)
      out_.warnings.push_back(fmt::format("{} instances too large for single precision: left out", too_large));
  }

  /// Adds the shapes that have a motion, each as a group with one instance.
  void add_moving_shapes() {
    const auto count = [&] { return static_cast<std::uint32_t>(out_.tables.instances.size()); };
    motion_.tables().first_moving_shape = count();
    for (const ShapeDescription& shape : in_.shapes) {
      if (!is_placed_by_motion(shape)) continue;
      const AnimatedTransform& motion = *motion_.transform(shape.motion);
      const Group group = add_group(std::span(&shape, 1), nullptr);
      if (group.range.shape_count == 0) continue;
      try {
        add_moving_instance(group, {motion, motion.reference().inverse()}, {});
      } catch (const SceneError& error) { omit(shape, error); }
    }
    motion_.tables().end_of_moving_shapes = count();
  }

  /// Adds an instance of a group that moves. `rest`: transform that places the tables of its lights.
  void add_moving_instance(const Group& group, const Motion& motion, const Transform& rest) {
    const std::vector<MotionStepRow> steps =
        tabulate_motion(motion, MotionProbes::of_box(group.bounds), motion_.shutter());
    // Bound the instance at all steps; in between it is in their convex hull
    for (const MotionStepRow& step : steps) {
      const Bounds3f bounds = instance_bounds(group.position(std::to_array(step.matrix)), group.bounds);
      if (!is_traceable(bounds)) throw SceneError("a moving object leaves the range of coordinates");
      out_.bounds.grow(bounds);
    }
    if (steps.size() > 1) {
      const std::size_t row = out_.tables.instances.size();
      MotionCompiler::set(motion_.tables().instances, row, motion_.add(steps));
      out_.moving_instances.push_back({static_cast<std::uint32_t>(row), single_rows(rest)});
    }
    push_instance(group.position(std::to_array(steps[0].matrix)), group);
  }

  void push_instance(const InstanceRow& row, const Group& group) {
    out_.tables.instances.push_back(row);
    out_.info.instanced_triangles += group.triangles;
  }

  /// Counts shapes and instances, pads the tables, and lays out mesh attributes.
  void finish() {
    GeometryTables& tables = out_.tables;
    if (tables.shapes.size() + tables.instances.size() >= kNone)
      throw SceneError("more than 2^32 shapes and instances");
    out_.info.shapes = tables.shapes.size();
    out_.info.groups = out_.groups.size();
    out_.info.instances = tables.instances.size();
    for (const OpenBoundaries::Gap& gap : open_boundaries_.gaps())
      out_.warnings.push_back(
          SceneError(gap.where, fmt::format("the mesh bounds a medium and has {} open edges: unless other shapes close "
                                            "it, paths enter and leave the medium unnoticed",
                                            gap.edges))
              .what());
    // Triangles are loaded four words at a time, and inactive lanes read row zero
    if (tables.vertices.empty()) tables.vertices.emplace_back();
    tables.vertices.shrink_to_fit();
    if (!tables.tangents.empty()) tables.tangents.resize(tables.vertices.size());
    tables.triangles.insert(tables.triangles.end(), kTrianglePadding, 0u);
    tables.triangles.shrink_to_fit();
    if (tables.quadrics.empty()) tables.quadrics.emplace_back();
    if (tables.shapes.empty()) tables.shapes.emplace_back();
    out_.attributes.finish(static_cast<std::uint32_t>(tables.shapes.size()));
    if (out_.bounds.is_empty()) out_.bounds = {};
  }

  const Description& in_;
  MeshReader& meshes_;
  const TextureTables& textures_;
  const CompiledMaterials& materials_;
  MotionCompiler& motion_;
  ErrorSink& errors_;
  OpenBoundaries open_boundaries_;
  CompiledGeometry out_;
};

}  // namespace

MeshReader::MeshReader(const Description& description) {
  std::vector<const ShapeDescription*> shapes;
  const auto add = [&](bool moves) {
    for (const ShapeDescription& shape : description.shapes)
      if (is_placed_by_motion(shape) == moves) shapes.push_back(&shape);
  };
  add(false);
  for (const ShapeGroup& group : description.groups)
    for (const ShapeDescription& shape : group.shapes) shapes.push_back(&shape);
  add(true);
  meshes_.emplace(mesh_jobs(shapes, description.shutter), read_ahead_bytes());
}

CompiledGeometry compile_geometry(const Description& description, MeshReader& meshes, const TextureTables& textures,
                                  const CompiledMaterials& materials, MotionCompiler& motion, ErrorSink& errors) {
  return GeometryCompiler(description, meshes, textures, materials, motion, errors).run();
}

}  // namespace sheaf

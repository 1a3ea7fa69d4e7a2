// Compiles shapes, shape groups and instances.
#include "core/math/frame.h"
#include "core/soa/large_pages.h"
#include "scene/accel/quadric.h"
#include "scene/compile/geometry/sample_height_field.h"
#include "scene/compile/scene_compiler.h"
#include "scene/tables/instance.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Makes room for `count` more elements: a quarter more than needed unless these are the first.
template <class T> void make_room(std::vector<T>& rows, std::size_t count) {
  const std::size_t needed = rows.size() + count;
  if (needed <= rows.capacity()) return;
  rows.reserve(rows.empty() ? needed : needed + needed / 4);
  prefer_large_pages(rows.data() + rows.size(), (rows.capacity() - rows.size()) * sizeof(T));
}

/// `at`: the mesh itself, or a later step of it.
void append(std::vector<VertexRow>& rows, const Mesh& mesh, const auto& at) {
  make_room(rows, mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3f p = at.positions[i];
    const Vec3f n = at.normals.empty() ? Vec3f{} : at.normals[i];
    const Vec2f uv = mesh.uvs.empty() ? Vec2f{} : mesh.uvs[i];
    rows.push_back({p, n, uv});
  }
}

/// Appends the tangents of the most recent vertices. SceneCompiler::finish_tables() adds those of later vertices.
void append_tangents(GeometryTables& geometry, const std::vector<MeshTangent>& tangents) {
  if (tangents.empty()) return;
  geometry.tangents.resize(geometry.vertices.size() - tangents.size());
  for (const MeshTangent& tangent : tangents) geometry.tangents.push_back({tangent.direction, tangent.handedness});
}

/// A canonical quadric with its transform.
struct Placement {
  ShapeKind kind;
  Transform to_world;
};

Placement place(const SphereShape& s, const Transform& t) {
  return {ShapeKind::kSphere, t * Transform::translate(s.center) * Transform::scale({s.radius, s.radius, s.radius})};
}
Placement place(const DiskShape&, const Transform& t) { return {ShapeKind::kDisk, t}; }
Placement place(const CylinderShape& c, const Transform& t) {
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
  place(shape, t);
};

}  // namespace

void SceneCompiler::add_shape(const ShapeDescription& shape) {
  ShapeRow row;
  row.material = shape.material ? row_of_material_.at(static_cast<std::size_t>(*shape.material)) : default_material_;
  try {
    if (has_prepared_mesh(shape)) return add_mesh(row, shape, meshes_->take(next_mesh_++));
    std::visit(Overloaded{
                   [&](const HeightFieldShape& field) {
                     Mesh mesh = sample_height_field(field, out_->textures_);
                     add_mesh(row, shape, prepare_mesh(shape, std::move(mesh), shape.face_normals));
                   },
                   [&](const Curves& curves) { add_curves(row, shape, curves); },
                   [&](const DeformingCurves& curves) { add_curves(row, shape, curves); },
                   [&](const SdfGrid& grid) { add_sdf_grid(row, shape, grid); },
                   [&](const IsQuadric auto& quadric) {
                     const Placement placement = place(quadric, shape.to_world);
                     add_quadric(row, shape, make_quadric(placement.kind, placement.to_world, shape.flip_normals));
                   },
                   [](const auto& /*mesh*/) {},
               },
               shape.geometry);
  } catch (const SceneError& error) { throw at_place(shape.where, error); }
}

void SceneCompiler::read_meshes_ahead() {
  std::vector<const ShapeDescription*> shapes;
  for (const ShapeDescription& shape : in_.shapes)
    (is_placed_by_motion(shape) ? moving_shapes_ : shapes).push_back(&shape);
  for (const ShapeGroup& group : in_.groups)
    for (const ShapeDescription& shape : group.shapes) shapes.push_back(&shape);
  shapes.insert(shapes.end(), moving_shapes_.begin(), moving_shapes_.end());
  meshes_.emplace(mesh_jobs(shapes, in_.shutter), read_ahead_bytes());
}

void SceneCompiler::add_mesh(ShapeRow row, const ShapeDescription& shape, PreparedMesh prepared) {
  const Mesh& mesh = prepared.mesh;
  for (std::string& warning : prepared.warnings) out_->warnings_.push_back(std::move(warning));
  open_boundaries_.add(std::move(prepared.open_edges));
  // Report defects
  if (prepared.dropped > 0)
    warn(shape, std::to_string(prepared.dropped) + " degenerate or non-finite triangles left out");
  if (mesh.triangles.empty()) {
    warn(shape, shape.radiance ? "shape has no area: neither visible nor emitting" : "shape has no area: left out");
    return;
  }
  // Append vertices and triangles
  GeometryTables& geometry = out_->geometry_;
  const std::size_t steps = prepared.later_steps.size() + 1;
  if (8 * (geometry.vertices.size() + steps * mesh.positions.size()) > kMaxWords ||
      geometry.triangles.size() + 3 * mesh.triangles.size() > kMaxWords)
    throw SceneError("more than " + std::to_string(kMaxWords / 3) + " vertices or triangles in all");
  row.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
  row.first_vertex = static_cast<std::uint32_t>(geometry.vertices.size());
  row.first_triangle = static_cast<std::uint32_t>(geometry.triangles.size() / 3);
  row.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
  row.flags = (mesh.normals.empty() ? 0u : kHasNormals) | (mesh.uvs.empty() ? 0u : kHasUvs);
  append(geometry.vertices, mesh, mesh);
  append_tangents(geometry, mesh.tangents);
  if (steps > 1) add_mesh_steps(row, mesh, prepared.later_steps);
  make_room(geometry.triangles, 3 * mesh.triangles.size() + kTrianglePadding);
  for (const auto& t : mesh.triangles) geometry.triangles.insert(geometry.triangles.end(), t.begin(), t.end());
  // Bound the mesh
  GridBox box{mesh.positions[mesh.triangles[0][0]], mesh.positions[mesh.triangles[0][0]]};
  for (const auto& t : mesh.triangles)
    for (std::uint32_t vertex : t) {
      grow_box(box.min, box.max, mesh.positions[vertex], mesh.positions[vertex]);
      for (const MeshStep& step : prepared.later_steps)
        grow_box(box.min, box.max, step.positions[vertex], step.positions[vertex]);
    }
  grow(box.min, box.max);
  add_attributes(row, mesh, shape.where);
  // Add the shape
  vertex_counts_.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
  out_->counts_.triangles += mesh.triangles.size();
  out_->counts_.vertices += mesh.positions.size();
  push_shape(row, shape, box);
}

void SceneCompiler::add_mesh_steps(ShapeRow& row, const Mesh& mesh, const std::vector<MeshStep>& later) {
  for (const MeshStep& step : later) {
    append(out_->geometry_.vertices, mesh, step);
    append_tangents(out_->geometry_, step.tangents);
  }
  add_deformation(row, later.size(), mesh.positions.size());
}

void SceneCompiler::add_deformation(ShapeRow& row, std::size_t segment_count, std::size_t vertex_count) {
  std::vector<DeformationRow>& motions = out_->motion_.deformations;
  motions.push_back({static_cast<std::uint32_t>(segment_count), static_cast<std::uint32_t>(vertex_count)});
  if (motions.size() >= std::size_t(1) << (32 - kDeformationShift)) throw SceneError("too many shapes that deform");
  row.flags |= static_cast<std::uint32_t>(motions.size()) << kDeformationShift;
}

void SceneCompiler::add_attributes(const ShapeRow& row, const Mesh& mesh, const SourceLocation& where) {
  const auto add = [&](const Mesh::Attribute& attribute) {
    attributes_->add(static_cast<std::uint32_t>(out_->geometry_.shapes.size()), row.first_triangle, row.triangle_count,
                     static_cast<std::uint32_t>(mesh.positions.size()), attribute, where);
  };
  for (const Mesh::Attribute& attribute : mesh.attributes) {
    known_attributes_.insert(attribute.name);
    if (attributes_->wants(attribute.name)) add(attribute);
  }
  for (const char* name : {kEdgeDistances, kRelativeEdgeDistances})
    if (attributes_->wants(name)) add({name, 3, edge_distances(mesh, name == kRelativeEdgeDistances)});
}

void SceneCompiler::add_quadric(ShapeRow row, const ShapeDescription& shape, const QuadricRow& quadric) {
  const QuadricBounds bounds = quadric_bounds(quadric);
  if (!is_traceable(bounds.lower, bounds.upper) || !(quadric.determinant > 0.0f)) {
    warn(shape, "shape is degenerate or too large for single precision: left out");
    return;
  }
  grow(bounds.lower, bounds.upper);
  row.kind = static_cast<std::uint32_t>(quadric.kind);
  row.first_triangle = static_cast<std::uint32_t>(out_->geometry_.quadrics.size());
  out_->geometry_.quadrics.push_back(quadric);
  vertex_counts_.push_back(0);
  ++out_->counts_.quadrics;
  push_shape(row, shape, {bounds.lower, bounds.upper});
}

void SceneCompiler::push_shape(ShapeRow row, const ShapeDescription& shape, const GridBox& box) {
  const auto index = static_cast<std::uint32_t>(out_->geometry_.shapes.size());
  if (!shape.is_visible) row.flags |= kUntraced;
  // Add the boundary between media
  if (shape.interior || shape.exterior) {
    row.boundary = static_cast<std::uint32_t>(out_->media_.boundaries.size());
    out_->media_.boundaries.push_back({hold(shape.interior, shape, box), hold(shape.exterior, shape, box)});
    if (shape.exterior_is_surrounding) surrounded_shapes_.push_back(index);
  }
  // Add the light
  if (const std::optional<TextureId> texture = emission_texture_of(shape))
    emission_textures_.emplace_back(index, static_cast<std::uint32_t>(*texture));
  if (const auto* texture = std::get_if<TextureId>(&shape.emission_coat); texture != nullptr && shape.radiance)
    emission_textures_.emplace_back(index, static_cast<std::uint32_t>(*texture));
  if (const std::optional<AreaEmission> emission = emission_of(shape)) {
    if (group_emitters_ != nullptr) {
      row.light = static_cast<std::uint32_t>(group_emitters_->size());
      group_emitters_->push_back({index, *emission, shape.where, emitter_name(shape)});
    } else {
      row.light = static_cast<std::uint32_t>(out_->lights_.rows.size());
      add_area_light(row, {index, *emission, shape.where, emitter_name(shape)}, nullptr);
    }
  }
  out_->geometry_.shapes.push_back(row);
  naming_.add_shape(shape, group_name_);
}

SceneCompiler::GroupContents SceneCompiler::add_group(std::span<const ShapeDescription> shapes,
                                                      const std::string& name) {
  // Redirect bounds and emitters to the group
  const Vec3f lower = lower_, upper = upper_;
  const std::size_t triangles = out_->counts_.triangles;
  const auto first = static_cast<std::uint32_t>(out_->geometry_.shapes.size());
  lower_ = {kInfinity, kInfinity, kInfinity};
  upper_ = {-kInfinity, -kInfinity, -kInfinity};
  std::vector<Emitter> emitters;
  group_emitters_ = &emitters;
  group_name_ = name;
  // Add the shapes
  for (const ShapeDescription& shape : shapes) add_shape(shape);
  group_emitters_ = nullptr;
  group_name_.clear();
  const ShapeRange range{first, static_cast<std::uint32_t>(out_->geometry_.shapes.size()) - first};
  // Collect the contents, and restore the bounds of the scene
  GroupContents contents{range,
                         static_cast<std::uint32_t>(group_ranges_.size()),
                         out_->counts_.triangles - triangles,
                         lower_,
                         upper_,
                         std::move(emitters)};
  if (range.shape_count > 0) group_ranges_.push_back(range);
  lower_ = lower;
  upper_ = upper;
  return contents;
}

void SceneCompiler::add_instances(const std::vector<GroupContents>& groups) {
  out_->geometry_.instances.reserve(in_.instances.size());
  std::size_t too_large = 0;
  for (const InstanceDescription& instance : in_.instances) {
    const GroupContents& group = groups.at(instance.group);
    if (group.range.shape_count == 0) continue;
    if (instance.motion) {
      const AnimatedTransform& motion = motion_of(*instance.motion);
      add_moving_instance(group, {motion, {}}, motion.reference());
      continue;
    }
    // Place the instance
    InstanceRow row = make_instance(rounded_rows(instance.to_world), group.range.first_shape, group.index);
    const InstanceBounds bounds = instance_bounds(row, group.lower, group.upper);
    if (!is_traceable(bounds.lower, bounds.upper)) {
      ++too_large;
      continue;
    }
    grow(bounds.lower, bounds.upper);
    // Add its lights
    row.first_light = static_cast<std::uint32_t>(out_->lights_.rows.size());
    const LightInstance placed{row};
    for (const Emitter& emitter : group.emitters)
      add_area_light(out_->geometry_.shapes[emitter.shape], emitter, &placed);
    out_->geometry_.instances.push_back(row);
    out_->counts_.instanced_triangles += group.triangles;
  }
  add_moving_shapes();
  if (too_large > 0)
    out_->warnings_.push_back(std::to_string(too_large) + " instances too large for single precision: left out");
  if (out_->geometry_.shapes.size() + out_->geometry_.instances.size() >= kNone)
    throw SceneError("more than 2^32 shapes and instances");
  out_->counts_.groups = group_ranges_.size();
  out_->counts_.instances = out_->geometry_.instances.size();
}

void SceneCompiler::grow(Vec3f lower, Vec3f upper) { grow_box(lower_, upper_, lower, upper); }

}  // namespace sheaf

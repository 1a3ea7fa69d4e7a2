// Meshes that deform: reads their keys, checks that they agree, and tabulates them over the shutter.
#include "scene/compile/geometry/prepare_mesh.h"
#include "scene/compile/key_times.h"
#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"

namespace sheaf {

namespace {

/// A mesh at the time of a key, in world space.
struct KeyMesh {
  double time = 0;
  Mesh mesh;
  bool is_split = false, makes_normals = false;  ///< see MeshFile, MeshFileShape::smooth_normals
};

KeyMesh read_key(const ShapeDescription& shape, const DeformingMesh::Key& key, std::vector<std::string>& warnings) {
  KeyMesh out;
  out.time = key.time;
  bool face_normals = shape.face_normals;
  if (const auto* from = std::get_if<MeshFileShape>(&key.mesh)) {
    MeshFile file = read_mesh(*from);
    out.mesh = std::move(file.mesh);
    out.is_split = file.is_split;
    out.makes_normals = from->smooth_normals;
    face_normals = face_normals || file.face_normals;
    for (const std::string& warning : file.warnings)
      warnings.push_back(fmt::format("{}: {}", from->file.string(), warning));
  } else {
    out.mesh = std::get<Mesh>(key.mesh);
  }
  check_mesh(out.mesh, shape.where);
  if (face_normals) {
    out.mesh.normals.clear();
    out.makes_normals = false;
  }
  return out;
}

/// Throws SceneError unless the meshes have the same vertices and triangles.
void check_same_topology(const KeyMesh& first, const KeyMesh& later, std::size_t number, const SourceLocation& where) {
  const auto differ = [&](const char* what, std::size_t a, std::size_t b) {
    throw SceneError(
        where, fmt::format("the meshes of a deformation differ in their {}: number 1 has {}, number {} has {}", what, a,
                           number, b));
  };
  const Mesh &a = first.mesh, &b = later.mesh;
  if (a.positions.size() != b.positions.size()) differ("vertices", a.positions.size(), b.positions.size());
  if (a.triangles.size() != b.triangles.size()) differ("triangles", a.triangles.size(), b.triangles.size());
  if (a.triangles != b.triangles)
    throw SceneError(where, fmt::format("the meshes of a deformation have different triangles: those of numbers 1 and "
                                        "{} connect different vertices",
                                        number));
  const auto check_presence = [&](const char* what, bool differ_in_it) {
    if (differ_in_it)
      throw SceneError(where,
                       fmt::format("only some meshes of a deformation have {}: numbers 1 and {} differ", what, number));
  };
  check_presence("normals", a.normals.empty() != b.normals.empty());
  check_presence("tangents", a.tangents.empty() != b.tangents.empty());
}

/// Whether a triangle can be traced at all times and has an area at one of them.
bool is_usable(const std::vector<KeyMesh>& keys, const std::vector<std::vector<bool>>& usable, std::uint32_t triangle) {
  bool has_area = false;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (!is_traceable_triangle(keys[k].mesh, triangle)) return false;
    has_area = has_area || usable[k][triangle];
  }
  return has_area;
}

/// Drops the triangles that are degenerate at all times; returns their number.
std::size_t drop_degenerate_triangles(std::vector<KeyMesh>& keys) {
  const std::size_t count = keys[0].mesh.triangles.size();
  std::vector<std::vector<bool>> usable;
  for (const KeyMesh& key : keys) {
    usable.emplace_back(count, false);
    for (const std::uint32_t triangle : usable_triangles(key.mesh)) usable.back()[triangle] = true;
  }
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < count; ++i)
    if (is_usable(keys, usable, i)) kept.push_back(i);
  if (kept.size() < count)
    for (KeyMesh& key : keys) key.mesh = extract_triangles(key.mesh, kept);
  return count - kept.size();
}

/// Replaces normals by smooth ones. `welded_vertices`: for each vertex the one that it shares its normal with, or
/// empty.
void compute_normals(Mesh& mesh, const std::vector<std::uint32_t>& welded_vertices) {
  if (welded_vertices.empty()) return compute_vertex_normals(mesh);
  Mesh welded{mesh.positions, {}, {}, mesh.triangles};
  for (auto& triangle : welded.triangles)
    for (std::uint32_t& vertex : triangle) vertex = welded_vertices[vertex];
  compute_vertex_normals(welded);
  mesh.normals.resize(welded_vertices.size());
  for (std::size_t i = 0; i < welded_vertices.size(); ++i) mesh.normals[i] = welded.normals[welded_vertices[i]];
}

/// The vertices at a time.
MeshStep step_at(const std::vector<KeyMesh>& keys, const KeyInterval& interval) {
  const Mesh &a = keys[interval.before].mesh, &b = keys[interval.after].mesh;
  MeshStep out{a.positions, a.normals, a.tangents};
  if (interval.before == interval.after) return out;
  const float t = interval.t;
  for (std::size_t i = 0; i < out.positions.size(); ++i)
    out.positions[i] = out.positions[i] * (1 - t) + b.positions[i] * t;
  for (std::size_t i = 0; i < out.normals.size(); ++i) {
    const Vec3f sum = out.normals[i] * (1 - t) + b.normals[i] * t;
    const float size = length(sum);
    if (size > 0) out.normals[i] = sum / size;
  }
  for (std::size_t i = 0; i < out.tangents.size(); ++i)
    out.tangents[i].direction = out.tangents[i].direction * (1 - t) + b.tangents[i].direction * t;
  return out;
}

/// Reads all keys, in world space, with the triangles of the first one.
std::vector<KeyMesh> read_keys(const ShapeDescription& shape, const DeformingMesh& from, PreparedMesh& prepared) {
  std::vector<KeyMesh> keys;
  for (const DeformingMesh::Key& key : from.keys) {
    keys.push_back(read_key(shape, key, prepared.warnings));
    check_same_topology(keys[0], keys.back(), keys.size(), shape.where);
  }
  for (std::size_t i = 0; i < keys.size(); ++i) transform_mesh(keys[i].mesh, shape.to_world * from.keys[i].to_shape);
  // The normals of the first key determine the front side
  for (KeyMesh& key : keys) key.mesh.triangles = keys[0].mesh.triangles;
  return keys;
}

}  // namespace

PreparedMesh prepare_deforming_mesh(const ShapeDescription& shape, const DeformingMesh& from,
                                    const ShutterDescription& shutter) {
  PreparedMesh prepared;
  std::vector<KeyMesh> keys = read_keys(shape, from, prepared);
  if (shape.interior != shape.exterior) prepared.open_edges = OpenBoundaries::find(keys[0].mesh, shape.where);
  prepared.dropped = drop_degenerate_triangles(keys);
  // Compute missing normals, and flip all
  std::vector<std::uint32_t> welded_vertices;
  if (keys[0].is_split) welded_vertices = same_positions(keys[0].mesh);
  for (KeyMesh& key : keys) {
    if (key.makes_normals && key.mesh.normals.empty()) compute_normals(key.mesh, welded_vertices);
    if (shape.flip_normals) flip_mesh(key.mesh);
  }
  // Tabulate the vertices over the shutter
  std::vector<double> times;
  for (const KeyMesh& key : keys) times.push_back(key.time);
  bool changes = false;
  const std::vector<double> steps = step_times(times, shutter);
  MeshStep first = step_at(keys, interval_at(times, steps[0]));
  for (std::size_t i = 1; i < steps.size(); ++i) {
    prepared.later_steps.push_back(step_at(keys, interval_at(times, steps[i])));
    const MeshStep& step = prepared.later_steps.back();
    changes = changes || step.positions != first.positions || step.normals != first.normals ||
              step.tangents != first.tangents;
  }
  if (!changes) prepared.later_steps.clear();
  prepared.mesh = std::move(keys[0].mesh);
  prepared.mesh.positions = std::move(first.positions);
  prepared.mesh.normals = std::move(first.normals);
  prepared.mesh.tangents = std::move(first.tangents);
  return prepared;
}

}  // namespace sheaf

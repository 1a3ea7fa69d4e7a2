// Adds meshes, and quadrics, to the geometry of a scene.
#include "core/io/parallel_ranges.h"
#include "core/soa/large_pages.h"
#include "scene/accel/quadric.h"
#include "scene/compile/geometry/compiled_geometry.h"

#include <cstring>
#include <mutex>

namespace sheaf {

namespace {

/// Makes room for `count` more elements: twice the needed memory unless these are the first. Memory without contents
/// takes addresses only.
template <class T> void make_room(std::vector<T>& rows, std::size_t count) {
  const std::size_t needed = rows.size() + count;
  if (needed > rows.capacity()) {
    rows.reserve(rows.empty() ? needed : 2 * needed);
    prefer_large_pages(rows.data() + rows.size(), (rows.capacity() - rows.size()) * sizeof(T));
  }
  prepare_pages(rows.data() + rows.size(), count * sizeof(T));
}

/// Appends the vertices of a mesh and their tangents. `at`: the mesh itself, or a later step of it. The tangents of
/// later vertices are added when the tables are complete.
void append(GeometryTables& tables, const Mesh& mesh, const auto& at) {
  make_room(tables.vertices, mesh.positions.size());
  const std::size_t first = tables.vertices.size();
  tables.vertices.resize(first + mesh.positions.size());
  parallel_ranges(mesh.positions.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f n = at.normals.empty() ? Vec3f{} : at.normals[i];
      const Vec2f uv = mesh.uvs.empty() ? Vec2f{} : mesh.uvs[i];
      tables.vertices[first + i] = {at.positions[i], n, uv};
    }
  });
  if (at.tangents.empty()) return;
  tables.tangents.resize(tables.vertices.size() - at.tangents.size());
  for (const MeshTangent& tangent : at.tangents) tables.tangents.push_back({tangent.direction, tangent.handedness});
}

/// Appends the triangles of a mesh.
void append_triangles(GeometryTables& tables, const Mesh& mesh) {
  make_room(tables.triangles, 3 * mesh.triangles.size() + kTrianglePadding);
  const std::size_t first = tables.triangles.size();
  tables.triangles.resize(first + 3 * mesh.triangles.size());
  parallel_ranges(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
    std::memcpy(&tables.triangles[first + 3 * begin], &mesh.triangles[begin],
                (end - begin) * sizeof(mesh.triangles[0]));
  });
}

/// Bounds of the vertices in use, at all steps.
Bounds3f bounds_of(const PreparedMesh& prepared) {
  const Mesh& mesh = prepared.mesh;
  Bounds3f bounds = Bounds3f::empty();
  std::mutex mutex;
  parallel_ranges(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
    Bounds3f box = Bounds3f::empty();
    for (std::size_t i = begin; i < end; ++i)
      for (const std::uint32_t vertex : mesh.triangles[i]) {
        box.grow(mesh.positions[vertex]);
        for (const MeshStep& step : prepared.later_steps) box.grow(step.positions[vertex]);
      }
    const std::lock_guard lock(mutex);
    bounds.grow(box);
  });
  return bounds;
}

/// Adds the attributes that textures use of a mesh that becomes the next shape.
void add_attributes(const ShapeRow& row, const Mesh& mesh, const SourceLocation& where, CompiledGeometry& out) {
  const auto add = [&](const Mesh::Attribute& attribute) {
    out.attributes.add(static_cast<std::uint32_t>(out.sources.size()), row.first_triangle, row.triangle_count,
                       static_cast<std::uint32_t>(mesh.positions.size()), attribute, where);
  };
  for (const Mesh::Attribute& attribute : mesh.attributes) {
    out.known_attributes.insert(attribute.name);
    if (out.attributes.wants(attribute.name)) add(attribute);
  }
  for (const char* name : {kEdgeDistances, kRelativeEdgeDistances})
    if (out.attributes.wants(name)) add({name, 3, edge_distances(mesh, name == kRelativeEdgeDistances)});
}

}  // namespace

std::optional<AddedShape> add_mesh(const ShapeDescription& shape, const PreparedMesh& prepared, MotionCompiler& motion,
                                   CompiledGeometry& out) {
  const Mesh& mesh = prepared.mesh;
  GeometryTables& tables = out.tables;
  // Report defects
  out.warnings.insert(out.warnings.end(), prepared.warnings.begin(), prepared.warnings.end());
  if (prepared.dropped > 0)
    out.warn(shape, fmt::format("{} degenerate or non-finite triangles left out", prepared.dropped));
  if (mesh.triangles.empty()) {
    out.warn(shape, shape.radiance ? "shape has no area: neither visible nor emitting" : "shape has no area: left out");
    return std::nullopt;
  }
  // Append vertices and triangles
  const std::size_t steps = prepared.later_steps.size() + 1;
  if (8 * (tables.vertices.size() + steps * mesh.positions.size()) > kMaxTableWords ||
      tables.triangles.size() + 3 * mesh.triangles.size() > kMaxTableWords)
    throw SceneError(fmt::format("more than {} vertices or triangles in all", kMaxTableWords / 3));
  AddedShape added;
  ShapeRow& row = added.row;
  row.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
  row.first_vertex = static_cast<std::uint32_t>(tables.vertices.size());
  row.first_triangle = static_cast<std::uint32_t>(tables.triangles.size() / 3);
  row.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
  row.flags = (mesh.normals.empty() ? 0u : kHasNormals) | (mesh.uvs.empty() ? 0u : kHasUvs);
  append(tables, mesh, mesh);
  for (const MeshStep& step : prepared.later_steps) append(tables, mesh, step);
  if (steps > 1) row.flags |= motion.add_deformation(steps - 1, mesh.positions.size());
  append_triangles(tables, mesh);
  added.box = bounds_of(prepared);
  add_attributes(row, mesh, shape.where, out);
  added.vertex_count = static_cast<std::uint32_t>(mesh.positions.size());
  out.info.triangles += mesh.triangles.size();
  out.info.vertices += mesh.positions.size();
  return added;
}

std::optional<AddedShape> add_quadric(const ShapeDescription& shape, const QuadricRow& quadric, CompiledGeometry& out) {
  const Bounds3f bounds = quadric_bounds(quadric);
  if (!is_traceable(bounds) || !(quadric.determinant > 0.0f)) {
    out.warn(shape, "shape is degenerate or too large for single precision: left out");
    return std::nullopt;
  }
  AddedShape added{{}, bounds};
  added.row.kind = static_cast<std::uint32_t>(quadric.kind);
  added.row.first_triangle = static_cast<std::uint32_t>(out.tables.quadrics.size());
  out.tables.quadrics.push_back(quadric);
  ++out.info.quadrics;
  return added;
}

}  // namespace sheaf

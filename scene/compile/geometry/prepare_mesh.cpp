#include "scene/compile/geometry/prepare_mesh.h"

#include "scene/formats/mesh_io.h"
#include "scene/formats/smooth_normals.h"
#include "scene/tables/shape_rows.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace sheaf {

namespace {

/// Vertices far from the origin of their mesh are reported if they are rounded by more than this fraction of the mean
/// length of an edge.
constexpr double kCoarse = 1.0 / 400;

/// The mean length of the edges of about a thousand triangles; NaN without triangles.
double mean_edge(const Mesh& mesh) {
  constexpr std::size_t kTriangles = 1000;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += mesh.triangles.size() / kTriangles + 1)
    for (std::size_t k = 0; k < 3; ++k, ++count)
      sum += length(Vec3d(mesh.positions[mesh.triangles[i][k]]) - mesh.positions[mesh.triangles[i][(k + 1) % 3]]);
  return sum / static_cast<double>(count);
}

/// The note on a mesh whose vertices have lost digits to an offset; empty if they have not.
std::string precision_note(const Mesh& mesh) {
  float largest = 0;
  for (const Vec3f p : mesh.positions) largest = std::max(largest, max_component(abs(p)));
  const double step = double{std::nextafter(largest, kInfinity)} - double{largest}, edge = mean_edge(mesh);
  if (!(step > kCoarse * edge)) return {};
  return fmt::format(
      "vertices are rounded to multiples of {:.3g}, because coordinates reach {:.3g} (mean edge {:.3g}): subtract an "
      "offset from them, and add it to the transform of the shape",
      step, largest, edge);
}

double copy_bytes(const Mesh& mesh) {
  return static_cast<double>(mesh.positions.size() * sizeof(VertexRow) + mesh.tangents.size() * sizeof(TangentRow) +
                             mesh.triangles.size() * sizeof(mesh.triangles[0]));
}

double job_bytes(const ShapeDescription& shape) {
  if (const auto* file = std::get_if<MeshFileShape>(&shape.geometry)) return mesh_reading_bytes(*file);
  if (const auto* deforming = std::get_if<DeformingMesh>(&shape.geometry)) {
    double bytes = 0;
    for (const DeformingMesh::Key& key : deforming->keys) {
      const auto* file = std::get_if<MeshFileShape>(&key.mesh);
      bytes += file != nullptr ? mesh_reading_bytes(*file) : copy_bytes(std::get<Mesh>(key.mesh));
    }
    return bytes;
  }
  const auto* mesh = std::get_if<Mesh>(&shape.geometry);
  return mesh != nullptr ? copy_bytes(*mesh) : 0;
}

}  // namespace

bool has_prepared_mesh(const ShapeDescription& shape) {
  return std::holds_alternative<MeshFileShape>(shape.geometry) || std::holds_alternative<Mesh>(shape.geometry) ||
         std::holds_alternative<RectangleShape>(shape.geometry) || std::holds_alternative<CubeShape>(shape.geometry) ||
         std::holds_alternative<DeformingMesh>(shape.geometry);
}

PreparedMesh prepare_mesh(const ShapeDescription& shape, const ShutterDescription& shutter) {
  if (const auto* deforming = std::get_if<DeformingMesh>(&shape.geometry))
    return prepare_deforming_mesh(shape, *deforming, shutter);
  if (const auto* mesh = std::get_if<Mesh>(&shape.geometry)) return prepare_mesh(shape, *mesh, shape.face_normals);
  if (std::holds_alternative<RectangleShape>(shape.geometry))
    return prepare_mesh(shape, rectangle_mesh(), shape.face_normals);
  if (std::holds_alternative<CubeShape>(shape.geometry)) return prepare_mesh(shape, cube_mesh(), shape.face_normals);
  const auto& from = std::get<MeshFileShape>(shape.geometry);
  MeshFile file = read_mesh(from);
  PreparedMesh prepared =
      prepare_mesh(shape, std::move(file.mesh), shape.face_normals || file.face_normals, file.is_split);
  for (const std::string& warning : file.warnings)
    prepared.warnings.push_back(fmt::format("{}: {}", from.file.string(), warning));
  return prepared;
}

PreparedMesh prepare_mesh(const ShapeDescription& shape, Mesh mesh, bool face_normals, bool is_split) {
  PreparedMesh prepared{std::move(mesh), {}};
  Mesh& out = prepared.mesh;
  // Transform the mesh to world space
  check_mesh(out, shape.where);
  if (const std::string note = precision_note(out); !note.empty())
    prepared.warnings.push_back(SceneError(shape.where, note).what());
  if (face_normals) out.normals.clear();
  transform_mesh(out, shape.to_world);
  // Find open edges around media, but not of rectangles, which are known to be open; drop degenerate triangles
  if (shape.interior != shape.exterior && !std::holds_alternative<RectangleShape>(shape.geometry))
    prepared.open_edges = OpenBoundaries::find(out, shape.where);
  prepared.dropped = drop_degenerate_triangles(out);
  // Compute missing normals, and flip all
  const auto* file = std::get_if<MeshFileShape>(&shape.geometry);
  if (file != nullptr && file->smooth_normals && !face_normals && out.normals.empty()) {
    if (is_split) {
      compute_welded_normals(out);
    } else {
      compute_vertex_normals(out);
    }
  }
  if (shape.flip_normals) flip_mesh(out);
  return prepared;
}

std::vector<ReadAhead<PreparedMesh>::Job> mesh_jobs(const std::vector<const ShapeDescription*>& shapes,
                                                    const ShutterDescription& shutter) {
  std::vector<ReadAhead<PreparedMesh>::Job> jobs;
  for (const ShapeDescription* shape : shapes)
    if (has_prepared_mesh(*shape))
      jobs.push_back({[shape, &shutter] { return prepare_mesh(*shape, shutter); }, job_bytes(*shape)});
  return jobs;
}

}  // namespace sheaf

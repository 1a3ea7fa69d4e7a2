#include "scene/formats/obj_mesh.h"

#include "core/soa/large_pages.h"
#include "scene/formats/polygon.h"

#include <algorithm>
#include <array>
#include <optional>
#include <unordered_map>

namespace sheaf {

namespace {

constexpr int kAbsent = -1;      ///< attribute absent
constexpr int kOutOfRange = -2;  ///< index without a value in the file

std::string out_of_range(const char* name, int index, std::size_t count) {
  return fmt::format("a face refers to {} {}, but there are {}", name, index, count);
}

/// Joins the pieces of a file.
class Joiner {
 public:
  Joiner(const ObjSource& source, BadFaces bad_faces) : source_(source), bad_faces_(bad_faces) {}

  ObjContent join(std::vector<ObjPiece> pieces) {
    content_.pieces = std::move(pieces);
    reserve();
    for (ObjPiece& piece : content_.pieces) add(piece);
    if (content_.runs.empty()) throw SceneError(SourceLocation{source_.file()}, "the OBJ file holds no faces");
    check_highest(content_.positions, "vertex", &ObjCorner::position);
    check_highest(content_.uvs, "texture coordinate", &ObjCorner::uv);
    check_highest(content_.normals, "normal", &ObjCorner::normal);
    return std::move(content_);
  }

 private:
  void reserve() {
    std::array<std::size_t, 3> counts{};
    for (const ObjPiece& piece : content_.pieces) {
      counts[0] += piece.positions.size();
      counts[1] += piece.uvs.size();
      counts[2] += piece.normals.size();
    }
    reserve_on_large_pages(content_.positions.values, counts[0]);
    reserve_on_large_pages(content_.uvs.values, counts[1]);
    reserve_on_large_pages(content_.normals.values, counts[2]);
  }

  void add(ObjPiece& piece) {
    for (const ObjPiece::RelativeFace& face : piece.relative_faces) resolve(piece, face);
    if (piece.error) std::rethrow_exception(piece.error);
    add(content_.positions, piece.positions, piece.highest.position);
    add(content_.uvs, piece.uvs, piece.highest.uv);
    add(content_.normals, piece.normals, piece.highest.normal);
    std::size_t faces = 0;
    for (const ObjPiece::Statement& statement : piece.statements) {
      add_faces(statement.face - faces);
      faces = statement.face;
      apply(statement);
    }
    add_faces(piece.faces.size() - faces);
    content_.short_faces += piece.short_faces;
    lines_ += piece.line_count;
  }

  template <class T> static void add(ObjContent::Attributes<T>& to, std::vector<T>& values, int highest) {
    to.values.insert(to.values.end(), values.begin(), values.end());
    values = {};  // free its memory
    to.highest = std::max(to.highest, highest);
  }

  /// Converts the negative indices of a face.
  void resolve(ObjPiece& piece, const ObjPiece::RelativeFace& relative) {
    const std::size_t line = piece.begin + piece.faces[relative.face].line;
    const std::size_t begin = relative.face == 0 ? 0 : piece.faces[relative.face - 1].end;
    for (std::size_t i = begin; i < piece.faces[relative.face].end; ++i) {
      ObjCorner& corner = piece.corners[i];
      resolve(corner.position, "vertex", content_.positions, relative.positions, line);
      resolve(corner.uv, "texture coordinate", content_.uvs, relative.uvs, line);
      resolve(corner.normal, "normal", content_.normals, relative.normals, line);
    }
  }

  /// `before`: number of values of the piece before the face. `line`: position of its line in the file.
  template <class T>
  void resolve(int& index, const char* name, ObjContent::Attributes<T>& list, int before, std::size_t line) {
    if (index >= kAbsent) return;
    const auto count = list.values.size() + static_cast<std::size_t>(before);
    const int negative = index + 1;
    index = static_cast<int>(count) + negative;
    list.highest = std::max(list.highest, index);
    if (index >= 0) return;
    index = kOutOfRange;
    report(list, line, out_of_range(name, negative, count));
  }

  /// Checks the maximum index at the end, because faces may precede the values that they use.
  template <class T> void check_highest(ObjContent::Attributes<T>& list, const char* name, int ObjCorner::*index) {
    if (list.highest < static_cast<int>(list.values.size())) return;
    for (const ObjPiece& piece : content_.pieces) {
      const auto found = std::find_if(piece.corners.begin(), piece.corners.end(),
                                      [&](const ObjCorner& corner) { return corner.*index == list.highest; });
      if (found == piece.corners.end()) continue;
      const auto face = std::upper_bound(
          piece.faces.begin(), piece.faces.end(), found - piece.corners.begin(),
          [](std::ptrdiff_t at, const ObjPiece::Face& f) { return at < static_cast<std::ptrdiff_t>(f.end); });
      report(list, piece.begin + face->line, out_of_range(name, list.highest + 1, list.values.size()));
      return;
    }
  }

  template <class T> void report(ObjContent::Attributes<T>& list, std::size_t line, const std::string& message) {
    const SourceLocation where = source_.where(line);
    if (bad_faces_ == BadFaces::kError) throw SceneError(where, message);
    if (list.first_bad.empty()) list.first_bad = fmt::format("line {}: {}", where.line, message);
  }

  void apply(const ObjPiece::Statement& statement) {
    switch (statement.kind) {
      case ObjLine::Kind::kMaterial:
        material_ = statement.name;
        material_line_ = lines_ + statement.line + 1;
        material_id_.reset();
        starts_run_ = true;
        break;
      case ObjLine::Kind::kSmoothing:
        content_.has_smoothing_groups = true;
        smoothing_group_ = statement.group;
        starts_run_ = true;
        break;
      default:
        content_.libraries.push_back({statement.name, {source_.file(), lines_ + statement.line + 1}});
    }
  }

  void add_faces(std::size_t count) {
    if (count == 0) return;
    if (!material_id_) material_id_ = id_of_material();
    if (starts_run_) content_.runs.push_back({faces_, *material_id_, smoothing_group_});
    starts_run_ = false;
    faces_ += count;
  }

  std::uint32_t id_of_material() {
    const auto [found, is_new] = ids_.try_emplace(material_, static_cast<std::uint32_t>(content_.materials.size()));
    if (is_new) {
      content_.materials.push_back(found->first);
      content_.material_lines.push_back(material_line_);
    }
    return found->second;
  }

  const ObjSource& source_;
  const BadFaces bad_faces_;
  int lines_ = 0;  ///< number of lines of the pieces before
  ObjContent content_;
  std::size_t faces_ = 0;
  std::string material_;                      ///< current material
  int material_line_ = 0;                     ///< line of its 'usemtl'
  std::optional<std::uint32_t> material_id_;  ///< its index after first use by a face
  std::uint32_t smoothing_group_ = 0;
  bool starts_run_ = true;
  std::unordered_map<std::string, std::uint32_t> ids_;
};

/// Whether any face uses the attribute.
template <class T> bool is_used(const ObjContent::Attributes<T>& list) {
  return list.highest != kAbsent && !list.values.empty();
}

struct CornerHash {
  std::size_t operator()(const ObjCorner& c) const {
    std::uint64_t h = static_cast<std::uint32_t>(c.position);
    for (const int index : {c.uv, c.normal}) {
      h = (h ^ (h >> 29)) * 0x9e3779b97f4a7c15u + static_cast<std::uint32_t>(index);
    }
    h *= 0xbf58476d1ce4e5b9u;
    return static_cast<std::size_t>(h ^ (h >> 32));
  }
};

/// Merges equal corners into vertices.
class VertexMerger {
 public:
  VertexMerger(const ObjContent& content, Mesh& mesh)
      : content_(content), mesh_(mesh), has_uvs_(is_used(content.uvs)), has_normals_(is_used(content.normals)) {
    // Most files have one vertex per position
    const std::size_t count = content.positions.values.size();
    reserve_on_large_pages(first_, count);
    first_.resize(count, kMissingVertex);
    reserve_on_large_pages(vertices_, count);
    reserve_on_large_pages(mesh.positions, count);
    if (has_uvs_) reserve_on_large_pages(mesh.uvs, count);
    if (has_normals_) reserve_on_large_pages(mesh.normals, count);
  }

  /// Returns kMissingVertex if the file has no such position.
  std::uint32_t vertex(const ObjCorner& corner) {
    if (!content_.positions.has(corner.position)) return kMissingVertex;
    // Search the first vertices at this position
    std::uint32_t& first = first_[static_cast<std::size_t>(corner.position)];
    std::uint32_t last = kMissingVertex;
    int visited = 0;
    for (std::uint32_t i = first; i != kMissingVertex; i = vertices_[i].next, ++visited) {
      if (vertices_[i].uv == corner.uv && vertices_[i].normal == corner.normal) return i;
      last = i;
    }
    if (visited == kMaxVisited) return crowded_vertex(corner);
    // Append a vertex
    const std::uint32_t added = add(corner);
    (last == kMissingVertex ? first : vertices_[last].next) = added;
    return added;
  }

 private:
  /// The first vertices at the same position form a list; crowded_ holds the others.
  struct Vertex {
    int uv, normal;
    std::uint32_t next;
  };
  static constexpr int kMaxVisited = 16;

  template <class T> static T value_or_zero(const ObjContent::Attributes<T>& list, int index) {
    return list.has(index) ? list.values[static_cast<std::size_t>(index)] : T{};
  }

  std::uint32_t add(const ObjCorner& corner) {
    const auto index = static_cast<std::uint32_t>(mesh_.positions.size());
    vertices_.push_back({corner.uv, corner.normal, kMissingVertex});
    mesh_.positions.push_back(content_.positions.values[static_cast<std::size_t>(corner.position)]);
    if (has_uvs_) mesh_.uvs.push_back(value_or_zero(content_.uvs, corner.uv));
    if (has_normals_) mesh_.normals.push_back(value_or_zero(content_.normals, corner.normal));
    return index;
  }

  /// A vertex at a position with many others.
  std::uint32_t crowded_vertex(const ObjCorner& corner) {
    const auto [found, is_new] = crowded_.try_emplace(corner, 0);
    if (is_new) found->second = add(corner);
    return found->second;
  }

  const ObjContent& content_;
  Mesh& mesh_;
  bool has_uvs_, has_normals_;
  std::vector<std::uint32_t> first_;  ///< per position of the file: its first vertex
  std::vector<Vertex> vertices_;
  std::unordered_map<ObjCorner, std::uint32_t, CornerHash> crowded_;
};

PolygonList merge_corners(ObjContent& content, Mesh& mesh) {
  PolygonList polygons{{}, {}, content.short_faces, content.positions.first_bad};
  std::size_t corners = 0, faces = 0;
  for (const ObjPiece& piece : content.pieces) {
    corners += piece.corners.size();
    faces += piece.faces.size();
  }
  reserve_on_large_pages(polygons.corners, corners);
  reserve_on_large_pages(polygons.ends, faces);
  VertexMerger merger(content, mesh);
  for (ObjPiece& piece : content.pieces) {
    const std::size_t begin = polygons.corners.size();
    for (const ObjCorner& corner : piece.corners) polygons.corners.push_back(merger.vertex(corner));
    for (const ObjPiece::Face& face : piece.faces) polygons.ends.push_back(begin + face.end);
    piece = {};  // free its memory
  }
  return polygons;
}

}  // namespace

ObjContent join_obj_pieces(const ObjSource& source, std::vector<ObjPiece> pieces, BadFaces bad_faces) {
  return Joiner(source, bad_faces).join(std::move(pieces));
}

ObjFile build_obj_mesh(ObjContent content) {
  ObjFile result;
  MeshFile& file = result.file;
  const PolygonList polygons = merge_corners(content, file.mesh);
  result.material_of = append_polygons(polygons, file.mesh, file.warnings);
  for (const std::string& bad : {content.uvs.first_bad, content.normals.first_bad})
    if (!bad.empty()) file.warnings.push_back("indices out of range ignored: " + bad);
  if (content.has_smoothing_groups) result.smoothing_of.reserve(result.material_of.size());
  auto run = content.runs.begin();
  for (std::uint32_t& source : result.material_of) {
    while (run + 1 != content.runs.end() && (run + 1)->first_face <= source) ++run;
    source = run->material;
    if (content.has_smoothing_groups) result.smoothing_of.push_back(run->smoothing_group);
  }
  result.materials = std::move(content.materials);
  result.material_lines = std::move(content.material_lines);
  result.libraries = std::move(content.libraries);
  return result;
}

}  // namespace sheaf

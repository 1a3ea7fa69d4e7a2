// Wavefront OBJ files: collects the content of the lines that ObjLines parses, and merges face corners into vertices.
#include "scene/formats/obj.h"

#include "scene/formats/polygon.h"
#include "scene/formats/text.h"

#include <limits>
#include <optional>
#include <unordered_map>

namespace sheaf {

namespace {

constexpr int kAbsent = -1;      ///< attribute absent
constexpr int kOutOfRange = -2;  ///< index without a value in the file

/// One corner of a face: 0-based indices into the file's lists, or kAbsent.
struct Corner {
  int position, uv, normal;
  bool operator==(const Corner&) const = default;
};

struct CornerHash {
  std::size_t operator()(const Corner& c) const {
    std::uint64_t h = static_cast<std::uint32_t>(c.position);
    for (const int index : {c.uv, c.normal}) {
      h = (h ^ (h >> 29)) * 0x9e3779b97f4a7c15u + static_cast<std::uint32_t>(index);
    }
    h *= 0xbf58476d1ce4e5b9u;
    return static_cast<std::size_t>(h ^ (h >> 32));
  }
};

/// One of the file's attribute lists, and the maximum index that faces use.
template <class T> struct AttributeList {
  const char* name;
  std::vector<T> values;
  int highest = kAbsent;
  int line_of_highest = 0;

  /// Converts an index of the file, 1-based or negative from the end, to a 0-based one; 0 becomes kAbsent. Indices
  /// before the first value are errors, or become kOutOfRange.
  int resolve(int index, const ObjLines& lines, BadFaces bad_faces) {
    if (index == 0) return kAbsent;
    const auto count = static_cast<int>(values.size());
    const int resolved = index > 0 ? index - 1 : count + index;
    if (resolved < 0) {
      if (bad_faces == BadFaces::kError) throw SceneError(lines.where(), out_of_range(index));
      if (first_bad.empty()) first_bad = at_line(lines.line(), index);
      return kOutOfRange;
    }
    if (resolved > highest) {
      highest = resolved;
      line_of_highest = lines.line();
    }
    return resolved;
  }
  /// Checks the maximum index after reading, because faces may precede the values that they use.
  void check_highest(const std::string& file, BadFaces bad_faces) {
    if (highest < static_cast<int>(values.size())) return;
    if (bad_faces == BadFaces::kError) throw SceneError({file, line_of_highest}, out_of_range(highest + 1));
    if (first_bad.empty()) first_bad = at_line(line_of_highest, highest + 1);
  }
  /// Whether a value with this index exists.
  bool has(int index) const { return index >= 0 && index < static_cast<int>(values.size()); }

  std::string first_bad = {};  ///< error message for the first index out of range

 private:
  std::string out_of_range(int index) const {
    return "a face refers to " + std::string(name) + " " + std::to_string(index) + ", but there are " +
           std::to_string(values.size());
  }
  std::string at_line(int line, int index) const { return "line " + std::to_string(line) + ": " + out_of_range(index); }
};

/// The parsed content of the file.
struct ObjContent {
  ObjContent(const ObjLines& from, BadFaces on_bad_faces) : lines(from), bad_faces(on_bad_faces) {}

  const ObjLines& lines;
  const BadFaces bad_faces;
  AttributeList<Vec3f> positions{"vertex", {}};
  AttributeList<Vec2f> uvs{"texture coordinate", {}};
  AttributeList<Vec3f> normals{"normal", {}};
  std::vector<Corner> corners;                ///< of all faces in sequence
  std::vector<std::size_t> face_ends;         ///< end of each face in `corners`
  std::size_t short_faces = 0;                ///< number of dropped faces with fewer than three corners
  std::vector<std::string> materials;         ///< names in order of first use
  std::vector<int> material_lines;            ///< line of the 'usemtl' of each
  std::vector<std::uint32_t> face_materials;  ///< per face: index into `materials`
  std::vector<std::uint32_t> face_smoothing;  ///< per face: smoothing group
  std::string material;                       ///< current material
  int material_line = 0;                      ///< line of its 'usemtl'
  std::optional<std::uint32_t> material_id;   ///< its index after first use by a face

  std::uint32_t id_of_material() {
    const auto next = static_cast<std::uint32_t>(materials.size());
    const auto [found, is_new] = ids_.try_emplace(material, next);
    if (is_new) {
      materials.push_back(material);
      material_lines.push_back(material_line);
    }
    return found->second;
  }

 private:
  std::unordered_map<std::string, std::uint32_t> ids_;
};

void add_position(ObjContent& content) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const ObjLines& lines = content.lines;
  content.positions.values.push_back(lines.is_non_finite() ? Vec3f{kNan, kNan, kNan} : lines.numbers());
}

void add_normal(ObjContent& content) {
  const bool usable = !content.lines.is_non_finite() && is_finite(content.lines.numbers());
  content.normals.values.push_back(usable ? content.lines.numbers() : Vec3f{0, 0, 0});
}

void add_uv(ObjContent& content) {
  const Vec3f uv = content.lines.numbers();
  content.uvs.values.push_back(!content.lines.is_non_finite() && is_finite(uv) ? Vec2f{uv.x, uv.y} : Vec2f{0, 0});
}

void add_face(ObjContent& content) {
  const ObjLines& lines = content.lines;
  if (lines.corners().size() < 3) {
    ++content.short_faces;
    return;
  }
  for (const ObjIndices& corner : lines.corners())
    content.corners.push_back({content.positions.resolve(corner.position, lines, content.bad_faces),
                               content.uvs.resolve(corner.uv, lines, content.bad_faces),
                               content.normals.resolve(corner.normal, lines, content.bad_faces)});
  content.face_ends.push_back(content.corners.size());
  if (!content.material_id) content.material_id = content.id_of_material();
  content.face_materials.push_back(*content.material_id);
  content.face_smoothing.push_back(lines.smoothing_group());
}

void use_material(ObjContent& content) {
  content.material_id.reset();
  content.material = content.lines.material();
  content.material_line = content.lines.line();
}

void parse(ObjLines& lines, ObjContent& content) {
  for (;;) switch (lines.next()) {
      case ObjLines::Kind::kPosition:
        add_position(content);
        break;
      case ObjLines::Kind::kNormal:
        add_normal(content);
        break;
      case ObjLines::Kind::kUv:
        add_uv(content);
        break;
      case ObjLines::Kind::kFace:
        add_face(content);
        break;
      case ObjLines::Kind::kMaterial:
        use_material(content);
        break;
      case ObjLines::Kind::kEnd:
        return;
    }
}

/// Merges equal corners into vertices.
class VertexMerger {
 public:
  VertexMerger(const ObjContent& content, Mesh& mesh)
      : content_(content),
        mesh_(mesh),
        has_uvs_(content.uvs.highest != kAbsent && !content.uvs.values.empty()),
        has_normals_(content.normals.highest != kAbsent && !content.normals.values.empty()),
        first_(content.positions.values.size(), kMissingVertex) {
    mesh.positions.reserve(content.positions.values.size());
  }

  /// Returns kMissingVertex if the file has no such position.
  std::uint32_t vertex(const Corner& corner) {
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

  template <class T> static T value_or_zero(const AttributeList<T>& list, int index) {
    return list.has(index) ? list.values[static_cast<std::size_t>(index)] : T{};
  }

  std::uint32_t add(const Corner& corner) {
    const auto index = static_cast<std::uint32_t>(mesh_.positions.size());
    vertices_.push_back({corner.uv, corner.normal, kMissingVertex});
    mesh_.positions.push_back(content_.positions.values[static_cast<std::size_t>(corner.position)]);
    if (has_uvs_) mesh_.uvs.push_back(value_or_zero(content_.uvs, corner.uv));
    if (has_normals_) mesh_.normals.push_back(value_or_zero(content_.normals, corner.normal));
    return index;
  }

  /// A vertex at a position with many others.
  std::uint32_t crowded_vertex(const Corner& corner) {
    const auto [found, is_new] = crowded_.try_emplace(corner, 0);
    if (is_new) found->second = add(corner);
    return found->second;
  }

  const ObjContent& content_;
  Mesh& mesh_;
  bool has_uvs_, has_normals_;
  std::vector<std::uint32_t> first_;  ///< per position of the file: its first vertex
  std::vector<Vertex> vertices_;
  std::unordered_map<Corner, std::uint32_t, CornerHash> crowded_;
};

ObjFile build_mesh(ObjContent content) {
  ObjFile result;
  MeshFile& file = result.file;
  VertexMerger merger(content, file.mesh);
  PolygonList polygons{{}, std::move(content.face_ends), content.short_faces, content.positions.first_bad};
  polygons.corners.reserve(content.corners.size());
  for (const Corner& corner : content.corners) polygons.corners.push_back(merger.vertex(corner));
  result.material_of = append_polygons(polygons, file.mesh, file.warnings);
  for (const std::string& bad : {content.uvs.first_bad, content.normals.first_bad})
    if (!bad.empty()) file.warnings.push_back("indices out of range ignored: " + bad);
  if (content.lines.has_smoothing_groups())
    for (const std::uint32_t face : result.material_of) result.smoothing_of.push_back(content.face_smoothing[face]);
  for (std::uint32_t& source : result.material_of) source = content.face_materials[source];
  result.materials = std::move(content.materials);
  result.material_lines = std::move(content.material_lines);
  result.libraries = content.lines.libraries();
  return result;
}

}  // namespace

ObjFile read_obj_with_materials(const std::filesystem::path& file, bool flip_tex_coords, BadFaces bad_faces) {
  const std::string name = file.string();
  std::string text = read_mesh_text(file, "OBJ file");
  if (text.empty()) throw SceneError({name}, "expected an OBJ file, found an empty file");
  if (!text.ends_with('\n')) text.push_back('\n');
  ObjLines lines(text, name);
  ObjContent content(lines, bad_faces);
  parse(lines, content);
  text = {};  // free its memory
  if (content.face_ends.empty()) throw SceneError({name}, "the OBJ file holds no faces");
  content.positions.check_highest(name, bad_faces);
  content.uvs.check_highest(name, bad_faces);
  content.normals.check_highest(name, bad_faces);
  if (flip_tex_coords) {
    for (Vec2f& uv : content.uvs.values) uv.y = 1 - uv.y;
  }
  const std::string first_bad = content.positions.first_bad;
  ObjFile obj = build_mesh(std::move(content));
  if (obj.file.mesh.triangles.empty()) throw SceneError({name}, "no face is complete: " + first_bad);
  return obj;
}

MeshFile read_obj(const std::filesystem::path& file, bool flip_tex_coords, BadFaces bad_faces) {
  return read_obj_with_materials(file, flip_tex_coords, bad_faces).file;
}

}  // namespace sheaf

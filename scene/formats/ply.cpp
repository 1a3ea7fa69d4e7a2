// Bodies of PLY files: rows of the elements 'vertex', 'face' and 'tristrips', in ASCII or binary.
#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/plain_ply.h"
#include "scene/formats/ply_attributes.h"
#include "scene/formats/ply_source.h"
#include "scene/formats/polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <type_traits>

namespace sheaf {

namespace {

/// Valid range of vertex indices, and handling of others.
struct PlyVertices {
  std::uint64_t count;
  BadFaces bad_faces;
};

/// The parsed body. Faces may precede the vertices, so polygons are triangulated at the end.
struct PlyContent {
  Mesh mesh;
  PolygonList polygons;
  /// Per polygon corner; trailing corners may be missing; may be empty.
  std::vector<Vec2f> corner_uvs;
  /// Values per polygon; trailing polygons may be missing.
  std::vector<Mesh::Attribute> polygon_attributes;
  std::vector<std::string> warnings;
};

constexpr int kUnwanted = -1;

/// Collects the values of an element's attributes row by row.
class AttributeRows {
 public:
  /// The attributes start with `rows_before` rows of zeros. Adds a warning that lists the properties that are neither
  /// attributes nor satisfy `is_known(index)`.
  template <class IsKnown>
  AttributeRows(const PlyElement& element, std::size_t rows_before, std::vector<std::string>& warnings,
                IsKnown is_known)
      : element_(element), columns_(element.properties.size(), kUnwanted) {
    std::vector<std::size_t> left_out, unknown;
    for (const PlyAttribute& found : find_ply_attributes(element, warnings, left_out)) {
      for (const std::size_t property : found.properties) {
        columns_[property] = static_cast<int>(row_.size());
        row_.push_back(0);
      }
      const std::size_t channels = found.properties.size();
      attributes_.push_back({found.name, static_cast<int>(channels), std::vector<float>(rows_before * channels)});
    }
    for (std::size_t k = 0; k < columns_.size(); ++k)
      if (columns_[k] == kUnwanted && !is_known(k) && std::find(left_out.begin(), left_out.end(), k) == left_out.end())
        unknown.push_back(k);
    if (!unknown.empty()) warnings.push_back(unknown_properties_warning(element, unknown));
  }

  /// Reads a property of the current row.
  template <class Source> void read(Source& source, std::size_t property) {
    const PlyProperty& p = element_.properties[property];
    if (columns_[property] == kUnwanted) {
      skip_property(source, p);
    } else {
      row_[static_cast<std::size_t>(columns_[property])] = ply_attribute_value(p.type, source.number(p.type));
    }
  }

  /// Appends the current row to the attributes.
  void push_row() {
    auto value = row_.begin();
    for (Mesh::Attribute& attribute : attributes_) {
      attribute.values.insert(attribute.values.end(), value, value + attribute.channels);
      value += attribute.channels;
    }
  }

  std::vector<Mesh::Attribute> take() { return std::move(attributes_); }

 private:
  const PlyElement& element_;
  std::vector<int> columns_;  ///< per property: its column in row_, or kUnwanted
  std::vector<float> row_;
  std::vector<Mesh::Attribute> attributes_;
};

/// Whether all properties are single floats in the byte order of this machine.
template <class Source> bool has_native_floats(const Source& source, const PlyElement& element) {
  const auto is_float = [](const PlyProperty& p) { return !p.count_type && p.type == PlyType::kFloat32; };
  if constexpr (std::is_same_v<Source, BinarySource>)
    return source.is_native() && std::all_of(element.properties.begin(), element.properties.end(), is_float);
  return false;
}

template <class Source>
void read_vertices(Source& source, const PlyElement& element, Mesh& mesh, std::vector<std::string>& warnings) {
  // Determine which properties are present
  std::vector<int> slots;
  std::array<bool, kPlySlots> has{};
  for (const PlyProperty& property : element.properties) {
    const std::optional<PlySlot> slot = ply_slot(property);
    slots.push_back(slot ? static_cast<int>(*slot) : kUnwanted);
    if (slots.back() != kUnwanted) has[static_cast<std::size_t>(slots.back())] = true;
  }
  if (!(has[kPlyX] && has[kPlyY] && has[kPlyZ])) source.fail("vertices without 'x', 'y' and 'z'");
  const bool has_normals = has[kPlyNormalX] && has[kPlyNormalY] && has[kPlyNormalZ], has_uvs = has[kPlyU] && has[kPlyV];
  mesh.positions.reserve(element.count);
  if (has_normals) mesh.normals.reserve(element.count);
  if (has_uvs) mesh.uvs.reserve(element.count);
  AttributeRows attributes(element, 0, warnings, [&](std::size_t k) { return slots[k] != kUnwanted; });
  const bool copies_rows =
      has_native_floats(source, element) && std::find(slots.begin(), slots.end(), kUnwanted) == slots.end();
  // Read the rows
  std::array<float, kPlySlots> values{};
  for (std::uint64_t row = 0; row < element.count; ++row) {
    source.enter_row(row);
    if constexpr (std::is_same_v<Source, BinarySource>)
      if (copies_rows) {
        const char* const bytes = source.take_bytes(slots.size() * sizeof(float));
        for (std::size_t k = 0; k < slots.size(); ++k)
          std::memcpy(&values[static_cast<std::size_t>(slots[k])], bytes + k * sizeof(float), sizeof(float));
      }
    for (std::size_t k = 0; !copies_rows && k < slots.size(); ++k) {
      if (slots[k] == kUnwanted) {
        attributes.read(source, k);
      } else {
        values[static_cast<std::size_t>(slots[k])] = static_cast<float>(source.number(element.properties[k].type));
      }
    }
    mesh.positions.push_back({values[kPlyX], values[kPlyY], values[kPlyZ]});
    const Vec3f normal{values[kPlyNormalX], values[kPlyNormalY], values[kPlyNormalZ]};
    if (has_normals) mesh.normals.push_back(is_finite(normal) ? normal : Vec3f{0, 0, 0});
    const bool is_uv = std::isfinite(values[kPlyU]) && std::isfinite(values[kPlyV]);
    if (has_uvs) mesh.uvs.push_back(is_uv ? Vec2f{values[kPlyU], values[kPlyV]} : Vec2f{0, 0});
    attributes.push_row();
  }
  mesh.attributes = attributes.take();
}

/// Validates the vertex index of a corner of `polygons`. An invalid one is an error or becomes kMissingVertex.
template <class Source>
std::uint32_t check_index(const Source& source, double index, const PlyVertices& vertices, PolygonList& polygons) {
  if (index >= 0 && index < static_cast<double>(vertices.count) && index == std::floor(index)) {
    return static_cast<std::uint32_t>(index);
  }
  constexpr double kMaxExact = 1e15;
  const bool is_whole = std::abs(index) < kMaxExact && index == std::floor(index);
  const auto message = [&] {
    return fmt::format("expected the index of one of {} vertices, found {}", vertices.count,
                       is_whole ? std::to_string(static_cast<std::int64_t>(index)) : std::to_string(index));
  };
  if (vertices.bad_faces == BadFaces::kError) source.fail(message());
  if (polygons.first_missing.empty()) polygons.first_missing = message();
  return kMissingVertex;
}

/// Reads a triangle strip: triangles share an edge with their predecessor and alternate in orientation; -1 starts a new
/// strip.
template <class Source>
void read_strip(Source& source, const PlyProperty& list, const PlyVertices& vertices, PolygonList& polygons) {
  std::vector<std::uint32_t> strip;
  for (std::uint64_t left = list_length(source, list); left > 0; --left) {
    const double index = source.number(list.type);
    if (index == -1) {
      strip.clear();
      continue;
    }
    strip.push_back(check_index(source, index, vertices, polygons));
    const std::size_t n = strip.size();
    if (n < 3) continue;
    std::array<std::uint32_t, 3> triangle{strip[n - 3], strip[n - 2], strip[n - 1]};
    if (n % 2 == 0) std::swap(triangle[1], triangle[2]);
    polygons.corners.insert(polygons.corners.end(), triangle.begin(), triangle.end());
    polygons.ends.push_back(polygons.corners.size());
  }
}

/// Reads a polygon of 32-bit indices in the byte order of this machine, if all are valid. Otherwise returns false and
/// leaves the source as it is.
bool read_native_corners(BinarySource& source, std::uint64_t length, const PlyVertices& vertices,
                         PolygonList& polygons) {
  const std::size_t begin = polygons.corners.size();
  polygons.corners.resize(begin + length);
  if (source.take_indices({&polygons.corners[begin], length}, vertices.count)) return true;
  polygons.corners.resize(begin);
  return false;
}

/// Reads a polygon; returns whether it has enough corners to be kept.
template <class Source>
bool read_polygon(Source& source, const PlyProperty& list, const PlyVertices& vertices, PolygonList& polygons) {
  const std::uint64_t length = list_length(source, list);
  const std::size_t begin = polygons.corners.size();
  bool is_read = false;
  if constexpr (std::is_same_v<Source, BinarySource>)
    if (source.is_native() && length > 0 && vertices.count <= std::numeric_limits<std::int32_t>::max() &&
        (list.type == PlyType::kInt32 || list.type == PlyType::kUint32))
      is_read = read_native_corners(source, length, vertices, polygons);
  for (std::uint64_t i = 0; !is_read && i < length; ++i) {
    polygons.corners.push_back(check_index(source, source.number(list.type), vertices, polygons));
  }
  if (length < 3) {
    polygons.corners.resize(begin);
    ++polygons.too_short;
    return false;
  }
  polygons.ends.push_back(polygons.corners.size());
  return true;
}

/// Returns the index of the list of corners among the properties of a face.
template <class Source> std::size_t find_corner_list(const Source& source, const PlyElement& element) {
  const auto list = std::find_if(element.properties.begin(), element.properties.end(), [](const PlyProperty& p) {
    return p.count_type && (p.name == "vertex_indices" || p.name == "vertex_index");
  });
  if (list == element.properties.end()) source.fail("no list 'vertex_indices' or 'vertex_index'");
  return static_cast<std::size_t>(list - element.properties.begin());
}

/// Returns the index of the list of texture coordinates of a face's corners, alternating u and v; the number of
/// properties if there is no such list.
std::size_t find_corner_uvs(const PlyElement& element) {
  const auto list = std::find_if(element.properties.begin(), element.properties.end(), [](const PlyProperty& p) {
    return p.count_type && (p.name == "texcoord" || p.name == "texcoords" || p.name == "texture_coordinates");
  });
  return static_cast<std::size_t>(list - element.properties.begin());
}

template <class Source>
void read_strips(Source& source, const PlyElement& element, const PlyVertices& vertices, PlyContent& content) {
  PolygonList& polygons = content.polygons;
  const std::size_t list = find_corner_list(source, element);
  std::vector<std::size_t> unknown;
  for (std::size_t k = 0; k < element.properties.size(); ++k)
    if (k != list) unknown.push_back(k);
  if (!unknown.empty()) content.warnings.push_back(unknown_properties_warning(element, unknown));
  for (std::uint64_t row = 0; row < element.count; ++row) {
    source.enter_row(row);
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      if (k == list) {
        read_strip(source, element.properties[k], vertices, polygons);
      } else {
        skip_property(source, element.properties[k]);
      }
    }
  }
}

/// Reads the texture coordinates of a face's corners into `uvs`; non-finite ones become 0.
template <class Source> void read_corner_uvs(Source& source, const PlyProperty& list, std::vector<Vec2f>& uvs) {
  const std::uint64_t length = list_length(source, list);
  if (length % 2 != 0)
    source.fail(fmt::format("list '{}' has {} numbers, expected two for each corner", list.name, length));
  uvs.clear();
  for (std::uint64_t i = 0; i < length; i += 2) {
    const auto u = static_cast<float>(source.number(list.type)), v = static_cast<float>(source.number(list.type));
    uvs.push_back(std::isfinite(u) && std::isfinite(v) ? Vec2f{u, v} : Vec2f{0, 0});
  }
}

template <class Source>
void read_faces(Source& source, const PlyElement& element, const PlyVertices& vertices, PlyContent& content) {
  const std::size_t list = find_corner_list(source, element), uv_list = find_corner_uvs(element);
  // Prepare the attributes
  AttributeRows attributes(element, content.polygons.ends.size(), content.warnings,
                           [&](std::size_t k) { return k == list || k == uv_list; });
  const bool has_uvs = uv_list < element.properties.size();
  std::vector<Vec2f> uvs;
  content.polygons.corners.reserve(content.polygons.corners.size() + 3 * element.count);
  content.polygons.ends.reserve(content.polygons.ends.size() + element.count);
  for (std::uint64_t row = 0; row < element.count; ++row) {
    source.enter_row(row);
    // Read a face
    const std::size_t begin = content.polygons.corners.size();
    bool kept = false;
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      if (k == list) {
        kept = read_polygon(source, element.properties[k], vertices, content.polygons);
      } else if (k == uv_list) {
        read_corner_uvs(source, element.properties[k], uvs);
      } else {
        attributes.read(source, k);
      }
    }
    if (!kept) continue;
    attributes.push_row();
    // Store its texture coordinates
    if (!has_uvs || (uvs.empty() && content.corner_uvs.empty())) continue;
    const std::size_t corners = content.polygons.corners.size() - begin;
    if (!uvs.empty() && uvs.size() != corners)
      source.fail(fmt::format("list '{}' has {} numbers, expected two for each of {} corners",
                              element.properties[uv_list].name, 2 * uvs.size(), corners));
    content.corner_uvs.resize(begin);
    uvs.resize(corners);
    content.corner_uvs.insert(content.corner_uvs.end(), uvs.begin(), uvs.end());
  }
  content.polygon_attributes = attributes.take();
}

/// Assigns corner texture coordinates to vertices. A vertex whose corners differ is duplicated; the copies follow the
/// original vertices.
void split_by_corner_uvs(PlyContent& content) {
  Mesh& mesh = content.mesh;
  const std::size_t count = mesh.positions.size();
  std::vector<std::uint32_t>& corners = content.polygons.corners;
  content.corner_uvs.resize(corners.size());
  std::vector<Vec2f> uvs(count);
  std::vector<bool> has_uv(count);
  std::vector<std::uint32_t> sources;
  std::map<std::tuple<std::uint32_t, float, float>, std::uint32_t> copies;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2f uv = content.corner_uvs[i];
    const std::uint32_t vertex = corners[i];
    if (vertex == kMissingVertex) continue;
    // Keep the first uv of a vertex, and copy the vertex for others
    if (!has_uv[vertex]) {
      uvs[vertex] = uv;
      has_uv[vertex] = true;
    } else if (uvs[vertex].x != uv.x || uvs[vertex].y != uv.y) {
      const auto next = static_cast<std::uint32_t>(count + sources.size());
      const auto [found, is_new] = copies.try_emplace({vertex, uv.x, uv.y}, next);
      if (is_new) {
        sources.push_back(vertex);
        uvs.push_back(uv);
      }
      corners[i] = found->second;
    }
  }
  // Append the copies
  append_vertex_copies(mesh, sources);
  mesh.uvs = std::move(uvs);
}

template <class Source>
PlyContent read_body(const std::string& bytes, const PlyHeader& header, const PlyVertices& vertices,
                     const std::string& file) {
  Source source(bytes, header, file);
  PlyContent content;
  for (const PlyElement& element : header.elements) {
    if (element.count == 0) continue;
    source.enter(element);
    source.enter_row(0);
    if (element.name == "vertex") {
      read_vertices(source, element, content.mesh, content.warnings);
    } else if (element.name == "face") {
      read_faces(source, element, vertices, content);
    } else if (element.name == "tristrips") {
      read_strips(source, element, vertices, content);
    } else {
      content.warnings.push_back(fmt::format("element '{}' not understood: left out", element.name.substr(0, 40)));
      for (std::uint64_t row = 0; row < element.count && !element.properties.empty(); ++row) {
        source.enter_row(row);
        for (const PlyProperty& property : element.properties) skip_property(source, property);
      }
    }
  }
  return content;
}

std::uint64_t count_vertices(const PlyHeader& header, const std::string& file) {
  for (const PlyElement& element : header.elements) {
    if (element.name != "vertex") continue;
    if (element.count <= std::numeric_limits<std::uint32_t>::max()) return element.count;
    throw SceneError(SourceLocation{file}, "a mesh of more than 2^32 - 1 vertices");
  }
  throw SceneError(SourceLocation{file}, "the PLY file has no element 'vertex'");
}

/// Converts a polygon attribute to one of the triangles.
Mesh::Attribute spread(const Mesh::Attribute& polygons, const std::vector<std::uint32_t>& polygon_of) {
  Mesh::Attribute triangles{polygons.name, polygons.channels, {}};
  triangles.values.reserve(polygon_of.size() * static_cast<std::size_t>(polygons.channels));
  for (const std::size_t polygon : polygon_of) {
    const auto row = polygons.values.begin() + static_cast<std::ptrdiff_t>(polygon) * polygons.channels;
    triangles.values.insert(triangles.values.end(), row, row + polygons.channels);
  }
  return triangles;
}

}  // namespace

MeshFile read_ply(const std::filesystem::path& file, bool flip_tex_coords, BadFaces bad_faces) {
  if (std::optional<MeshFile> plain = read_plain_ply(file, flip_tex_coords)) return std::move(*plain);
  const std::string name = file.string();
  const std::string bytes = read_mesh_text(file, "PLY file");
  const PlyHeader header = parse_ply_header(bytes, name);
  const PlyVertices vertices{count_vertices(header, name), bad_faces};
  PlyContent content = header.encoding == PlyHeader::Encoding::kAscii
                           ? read_body<AsciiSource>(bytes, header, vertices, name)
                           : read_body<BinarySource>(bytes, header, vertices, name);
  // Check the counts and resolve texture coordinates
  if (content.polygons.ends.empty()) throw SceneError(SourceLocation{name}, "the PLY file holds no faces");
  const bool has_corner_uvs = !content.corner_uvs.empty();
  if (content.mesh.positions.size() + content.polygons.corners.size() >= std::numeric_limits<std::uint32_t>::max())
    throw SceneError(SourceLocation{name}, "a mesh of more than 2^32 - 1 vertices and corners");
  if (has_corner_uvs) split_by_corner_uvs(content);
  if (flip_tex_coords) {
    for (Vec2f& uv : content.mesh.uvs) uv.y = 1 - uv.y;
  }
  // Triangulate the polygons
  MeshFile result{std::move(content.mesh), std::move(content.warnings)};
  result.is_split = has_corner_uvs;
  result.texture = header.texture;
  const std::vector<std::uint32_t> sources = append_polygons(content.polygons, result.mesh, result.warnings);
  if (result.mesh.triangles.empty())
    throw SceneError(SourceLocation{name}, "no face is complete: " + content.polygons.first_missing);
  for (Mesh::Attribute& attribute : content.polygon_attributes) {
    attribute.values.resize(content.polygons.ends.size() * static_cast<std::size_t>(attribute.channels));
    result.mesh.attributes.push_back(spread(attribute, sources));
  }
  return result;
}

}  // namespace sheaf

// Triangle mesh functions. Areas, angles and normals are computed in double precision, where products of three finite
// single-precision lengths neither overflow nor vanish.
#include "scene/formats/mesh.h"

#include "core/io/parallel_ranges.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace sheaf {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Normalizes a vector; returns zero for a vector without a direction.
Vec3d direction(Vec3d a) {
  const double l = length(a);
  return l > 0 && std::isfinite(l) ? a * (1 / l) : Vec3d{};
}
bool is_zero(Vec3f a) { return a.x == 0 && a.y == 0 && a.z == 0; }

/// Returns the geometric normal, with twice the area as length.
Vec3d area_normal(const Mesh& mesh, const Triangle& t) {
  const Vec3d a(mesh.positions[t[0]]);
  return cross(Vec3d(mesh.positions[t[1]]) - a, Vec3d(mesh.positions[t[2]]) - a);
}

/// Returns the angle at the first of three points, radians; 0 if two coincide.
double angle_at(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3d u = Vec3d(a) - Vec3d(p), v = Vec3d(b) - Vec3d(p);
  const double angle = std::atan2(length(cross(u, v)), dot(u, v));
  return std::isfinite(angle) ? angle : 0;
}

/// What a triangle adds to the normals of its vertices.
struct WeightedNormal {
  Vec3d normal;
  std::array<double, 3> angles;
};

/// Calls add(triangle, WeightedNormal) for the triangles with is_wanted(triangle), in order. Threads compute the
/// normals and angles of many triangles at a time.
template <class IsWanted, class Add>
void for_weighted_normals(const Mesh& mesh, const IsWanted& is_wanted, const Add& add) {
  constexpr std::size_t kAtATime = std::size_t{1} << 17;
  std::vector<WeightedNormal> found(std::min(kAtATime, mesh.triangles.size()));
  for (std::size_t begin = 0; begin < mesh.triangles.size(); begin += kAtATime) {
    const std::size_t count = std::min(kAtATime, mesh.triangles.size() - begin);
    parallel_ranges(count, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Triangle& t = mesh.triangles[begin + i];
        if (!is_wanted(t)) continue;
        found[i].normal = direction(area_normal(mesh, t));
        for (std::size_t k = 0; k < 3; ++k)
          found[i].angles[k] =
              angle_at(mesh.positions[t[k]], mesh.positions[t[(k + 1) % 3]], mesh.positions[t[(k + 2) % 3]]);
      }
    });
    for (std::size_t i = 0; i < count; ++i)
      if (is_wanted(mesh.triangles[begin + i])) add(mesh.triangles[begin + i], found[i]);
  }
}

/// Gives a smooth normal to every vertex whose normal is zero. `normals` is as long as `positions`.
void fill_zero_normals(Mesh& mesh) {
  const auto is_missing = [&](std::uint32_t vertex) { return is_zero(mesh.normals[vertex]); };
  if (std::none_of(mesh.normals.begin(), mesh.normals.end(), is_zero)) return;
  std::vector<Vec3d> sums(mesh.positions.size()), spares(mesh.positions.size());
  // Sum the normals of the triangles at each vertex
  for_weighted_normals(
      mesh, [&](const Triangle& t) { return std::any_of(t.begin(), t.end(), is_missing); },
      [&](const Triangle& t, const WeightedNormal& weighted) {
        for (std::size_t k = 0; k < 3; ++k) {
          sums[t[k]] = sums[t[k]] + weighted.normal * weighted.angles[k];
          if (dot(weighted.normal, weighted.normal) > 0) spares[t[k]] = weighted.normal;
        }
      });
  parallel_ranges(mesh.normals.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_zero(mesh.normals[i])) continue;
      constexpr double kCanceled = 1e-9;  // for triangles back to back
      mesh.normals[i] = (length(sums[i]) > kCanceled ? direction(sums[i]) : spares[i]).rounded();
      if (is_zero(mesh.normals[i])) mesh.normals[i] = {0, 0, 1};
    }
  });
}

/// Calls change(row) for all rows, by all threads.
template <class T, class Change> void for_each_row(std::vector<T>& rows, const Change& change) {
  parallel_ranges(rows.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) change(rows[i]);
  });
}

void reverse(Triangle& t) { std::swap(t[1], t[2]); }

void orient_by_normals(Mesh& mesh) {
  for_each_row(mesh.triangles, [&](Triangle& t) {
    const Vec3d sum = Vec3d(mesh.normals[t[0]]) + Vec3d(mesh.normals[t[1]]) + Vec3d(mesh.normals[t[2]]);
    if (dot(area_normal(mesh, t), sum) < 0) reverse(t);
  });
}

bool is_degenerate(const Mesh& mesh, const Triangle& t) {
  constexpr double kSmallestDoubleArea = 1e-37;
  constexpr double kSmallestRatio = 0x1p-22;  // twice the area over the squared longest edge
  for (const std::uint32_t vertex : t) {
    if (vertex >= mesh.positions.size()) return true;
    const Vec3f p = mesh.positions[vertex];
    for (const float c : {p.x, p.y, p.z}) {
      if (!(std::abs(c) <= kMaxMeshCoordinate)) return true;
    }
  }
  double longest_squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d edge = Vec3d(mesh.positions[t[(k + 1) % 3]]) - Vec3d(mesh.positions[t[k]]);
    longest_squared = std::max(longest_squared, dot(edge, edge));
  }
  const double double_area = length(area_normal(mesh, t));
  return double_area < kSmallestDoubleArea || double_area < kSmallestRatio * longest_squared;
}

/// Returns the rows of `values` with the indices `sources`; a row has `width` values.
template <class T>
std::vector<T> select_rows(const std::vector<T>& values, const std::vector<std::uint32_t>& sources,
                           std::size_t width = 1) {
  std::vector<T> selected;
  if (values.empty()) return selected;
  selected.reserve(sources.size() * width);
  for (const std::uint32_t source : sources) {
    const auto row = values.begin() + static_cast<std::ptrdiff_t>(source * width);
    selected.insert(selected.end(), row, row + static_cast<std::ptrdiff_t>(width));
  }
  return selected;
}

bool is_per_vertex(const Mesh::Attribute& attribute) { return attribute.name.starts_with("vertex_"); }

/// Adds a square around `center` with half edges u and v. Its front faces `normal`.
void append_square(Mesh& mesh, Vec3f center, Vec3f normal, Vec3f u, Vec3f v) {
  constexpr std::array<Vec2f, 4> kCorners{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec2f corner : kCorners) {
    mesh.positions.push_back(center + u * (2 * corner.x - 1) + v * (2 * corner.y - 1));
    mesh.normals.push_back(normal);
    mesh.uvs.push_back(corner);
  }
  const bool is_front = sheaf::dot(sheaf::cross(u, v), normal) > 0;
  for (Triangle t : {Triangle{first, first + 1, first + 2}, Triangle{first, first + 2, first + 3}}) {
    if (!is_front) reverse(t);
    mesh.triangles.push_back(t);
  }
}

}  // namespace

Mesh rectangle_mesh() {
  Mesh mesh;
  append_square(mesh, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0});
  return mesh;
}

Mesh cube_mesh() {
  struct Face {
    Vec3f normal, u, v;
  };
  constexpr std::array<Face, 6> kFaces{{{{0, -1, 0}, {0, 0, 1}, {1, 0, 0}},
                                        {{0, 1, 0}, {-1, 0, 0}, {0, 0, -1}},
                                        {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}},
                                        {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}},
                                        {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                        {{0, 0, -1}, {0, -1, 0}, {1, 0, 0}}}};
  Mesh mesh;
  for (const Face& face : kFaces) append_square(mesh, face.normal, face.normal, face.u, face.v);
  return mesh;
}

void check_mesh(const Mesh& mesh, const SourceLocation& where) {
  const std::size_t count = mesh.positions.size();
  const auto check_length = [&](std::size_t length, const char* what) {
    if (length == 0 || length == count) return;
    throw SceneError(where, fmt::format("a mesh has {} {} for {} vertices", length, what, count));
  };
  // Check vertex data and attributes
  check_length(mesh.normals.size(), "normals");
  check_length(mesh.uvs.size(), "texture coordinates");
  check_length(mesh.tangents.size(), "tangents");
  for (const Mesh::Attribute& attribute : mesh.attributes) {
    const std::size_t rows = is_per_vertex(attribute) ? count : mesh.triangles.size();
    const auto channels = static_cast<std::size_t>(std::max(attribute.channels, 1));
    if (attribute.values.size() == rows * channels) continue;
    throw SceneError(where, fmt::format("attribute '{}' has {} values, expected {} for each of {}", attribute.name,
                                        attribute.values.size(), channels, rows));
  }
  std::atomic<std::size_t> first_bad{mesh.triangles.size()};
  parallel_ranges(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
    const auto is_bad = [&](const Triangle& t) { return std::max({t[0], t[1], t[2]}) >= count; };
    const auto rows = mesh.triangles.begin();
    const auto found =
        std::find_if(rows + static_cast<std::ptrdiff_t>(begin), rows + static_cast<std::ptrdiff_t>(end), is_bad);
    const auto bad = static_cast<std::size_t>(found - rows);
    if (bad == end) return;
    std::size_t first = first_bad;
    while (bad < first && !first_bad.compare_exchange_weak(first, bad)) {}
  });
  if (first_bad == mesh.triangles.size()) return;
  const Triangle& t = mesh.triangles[first_bad];
  throw SceneError(where, fmt::format("a triangle refers to vertex {} (counted from 0), but there are {}",
                                      std::max({t[0], t[1], t[2]}), count));
}

void transform_mesh(Mesh& mesh, const Transform& to_world) {
  for_each_row(mesh.positions, [&](Vec3f& p) { p = to_world.point(p); });
  if (mesh.normals.empty()) return mesh.tangents.clear();
  for_each_row(mesh.normals, [&](Vec3f& n) { n = direction(to_world.normal(n)).rounded(); });
  for (MeshTangent& t : mesh.tangents) t.direction = direction(to_world.vector(t.direction)).rounded();
  if (to_world.swaps_handedness()) {
    for (Triangle& t : mesh.triangles) reverse(t);
    for (MeshTangent& t : mesh.tangents) t.handedness = -t.handedness;
  }
  orient_by_normals(mesh);
  fill_zero_normals(mesh);
}

void apply_linear_part(Mesh& mesh, Transform& to_world) {
  const Transform translation = Transform::translate(to_world.translation());
  transform_mesh(mesh, translation.inverse() * to_world);
  to_world = translation;
}

void flip_mesh(Mesh& mesh) {
  for (Triangle& t : mesh.triangles) reverse(t);
  for (Vec3f& n : mesh.normals) n = -n;
  for (MeshTangent& t : mesh.tangents) t.handedness = -t.handedness;
}

void compute_vertex_normals(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Vec3f{0, 0, 0});
  fill_zero_normals(mesh);
}

void append_vertex_copies(Mesh& mesh, const std::vector<std::uint32_t>& sources) {
  const auto append = [&](auto& values, std::size_t width) {
    const auto copies = select_rows(values, sources, width);
    values.insert(values.end(), copies.begin(), copies.end());
  };
  append(mesh.positions, 1);
  append(mesh.normals, 1);
  append(mesh.uvs, 1);
  append(mesh.tangents, 1);
  for (Mesh::Attribute& attribute : mesh.attributes)
    if (is_per_vertex(attribute)) append(attribute.values, static_cast<std::size_t>(attribute.channels));
}

Mesh extract_triangles(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  Mesh part;
  part.triangles = select_rows(mesh.triangles, triangles);
  // Renumber the vertices in use
  std::vector<std::uint32_t> renamed(mesh.positions.size(), kUnused), vertices;
  for (Triangle& t : part.triangles) {
    for (std::uint32_t& vertex : t) {
      if (renamed[vertex] == kUnused) {
        renamed[vertex] = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(vertex);
      }
      vertex = renamed[vertex];
    }
  }
  // Copy their data
  part.positions = select_rows(mesh.positions, vertices);
  part.normals = select_rows(mesh.normals, vertices);
  part.uvs = select_rows(mesh.uvs, vertices);
  part.tangents = select_rows(mesh.tangents, vertices);
  for (const Mesh::Attribute& a : mesh.attributes) {
    const auto& rows = is_per_vertex(a) ? vertices : triangles;
    part.attributes.push_back({a.name, a.channels, select_rows(a.values, rows, static_cast<std::size_t>(a.channels))});
  }
  return part;
}

std::vector<std::uint32_t> usable_triangles(const Mesh& mesh) {
  std::vector<std::uint32_t> usable;
  usable.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!is_degenerate(mesh, mesh.triangles[i])) usable.push_back(i);
  }
  return usable;
}

bool is_traceable_triangle(const Mesh& mesh, std::uint32_t triangle) {
  const auto is_small = [](float c) { return std::abs(c) <= kMaxMeshCoordinate; };
  const Triangle& t = mesh.triangles[triangle];
  return std::all_of(t.begin(), t.end(), [&](std::uint32_t vertex) {
    const Vec3f p = mesh.positions[vertex];
    return is_small(p.x) && is_small(p.y) && is_small(p.z);
  });
}

std::size_t drop_degenerate_triangles(Mesh& mesh) {
  std::atomic<std::size_t> dropped{0};
  parallel_ranges(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
    const auto rows = mesh.triangles.begin();
    const auto is_dropped = [&](const Triangle& t) { return is_degenerate(mesh, t); };
    dropped += static_cast<std::size_t>(
        std::count_if(rows + static_cast<std::ptrdiff_t>(begin), rows + static_cast<std::ptrdiff_t>(end), is_dropped));
  });
  if (dropped > 0) mesh = extract_triangles(mesh, usable_triangles(mesh));
  return dropped;
}

std::vector<float> edge_distances(const Mesh& mesh, bool relative) {
  std::vector<float> heights;
  heights.reserve(3 * mesh.triangles.size());
  double sum = 0;
  for (const auto& triangle : mesh.triangles) {
    const Vec3f p[3] = {mesh.positions[triangle[0]], mesh.positions[triangle[1]], mesh.positions[triangle[2]]};
    const float twice_area = length(cross(p[1] - p[0], p[2] - p[0]));
    for (std::size_t k = 0; k < 3; ++k) {
      const float across = length(p[(k + 2) % 3] - p[(k + 1) % 3]);
      heights.push_back(twice_area / across);
      sum += static_cast<double>(across);
    }
  }
  const float scale = relative && sum > 0 ? static_cast<float>(10.0 * static_cast<double>(heights.size()) / sum) : 1.0f;
  for (float& height : heights) height *= scale;
  return heights;
}

std::vector<std::uint32_t> same_positions(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.positions.size()), same(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto position = [&](std::uint32_t vertex) {
    const Vec3f& p = mesh.positions[vertex];
    return std::tuple(p.x + 0.0f, p.y + 0.0f, p.z + 0.0f);  // -0 is 0
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return position(a) != position(b) ? position(a) < position(b) : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    same[order[i]] = i > 0 && position(order[i]) == position(order[i - 1]) ? same[order[i - 1]] : order[i];
  return same;
}

std::vector<std::array<std::uint32_t, 2>> open_edges(const Mesh& mesh) {
  const std::vector<std::uint32_t> same = same_positions(mesh);
  struct Edge {
    std::uint64_t ends;
    int winding;
  };
  // Collect the edges with their directions
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = same[triangle[k]], b = same[triangle[(k + 1) % 3]];
      if (a != b) edges.push_back({std::min(a, b) << 32 | std::max(a, b), a < b ? 1 : -1});
    }
  // Find edges whose directions do not cancel
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
  std::vector<std::array<std::uint32_t, 2>> open;
  for (std::size_t i = 0; i < edges.size();) {
    int balance = 0;
    const std::uint64_t ends = edges[i].ends;
    for (; i < edges.size() && edges[i].ends == ends; ++i) balance += edges[i].winding;
    if (balance != 0) open.push_back({static_cast<std::uint32_t>(ends >> 32), static_cast<std::uint32_t>(ends)});
  }
  return open;
}

}  // namespace sheaf

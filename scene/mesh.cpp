// Helpers on triangle meshes. Areas, angles and normals are computed in double precision, where no product of three
// finite single-precision lengths overflows or vanishes.
#include "scene/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sheaf {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

struct Double3 {
  double x = 0, y = 0, z = 0;
  Double3() = default;
  Double3(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
  explicit Double3(Vec3f v) : x(v.x), y(v.y), z(v.z) {}
};
Double3 operator-(Double3 a, Double3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Double3 operator+(Double3 a, Double3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Double3 operator*(Double3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double dot(Double3 a, Double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(Double3 a) { return std::sqrt(dot(a, a)); }
Double3 cross(Double3 a, Double3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/// The unit vector, or zero for one that has no direction.
Double3 direction(Double3 a) {
  const double l = length(a);
  return l > 0 && std::isfinite(l) ? a * (1 / l) : Double3{};
}
Vec3f to_float(Double3 a) { return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)}; }
bool is_zero(Vec3f a) { return a.x == 0 && a.y == 0 && a.z == 0; }

/// The geometric normal times twice the area.
Double3 area_normal(const Mesh& mesh, const Triangle& t) {
  const Double3 a(mesh.positions[t[0]]);
  return cross(Double3(mesh.positions[t[1]]) - a, Double3(mesh.positions[t[2]]) - a);
}

/// The angle at the first of three points, in radians; 0 if two coincide.
double angle_at(Vec3f p, Vec3f a, Vec3f b) {
  const Double3 u = Double3(a) - Double3(p), v = Double3(b) - Double3(p);
  const double angle = std::atan2(length(cross(u, v)), dot(u, v));
  return std::isfinite(angle) ? angle : 0;
}

/// Gives a smooth normal to every vertex whose normal is zero. `normals` is as long as `positions`.
void fill_zero_normals(Mesh& mesh) {
  const auto is_missing = [&](std::uint32_t vertex) { return is_zero(mesh.normals[vertex]); };
  if (std::none_of(mesh.normals.begin(), mesh.normals.end(), is_zero)) return;
  std::vector<Double3> sums(mesh.positions.size()), spares(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    if (std::none_of(t.begin(), t.end(), is_missing)) continue;
    const Double3 normal = direction(area_normal(mesh, t));
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f p = mesh.positions[t[k]], a = mesh.positions[t[(k + 1) % 3]], b = mesh.positions[t[(k + 2) % 3]];
      sums[t[k]] = sums[t[k]] + normal * angle_at(p, a, b);
      if (dot(normal, normal) > 0) spares[t[k]] = normal;
    }
  }
  for (std::uint32_t i = 0; i < mesh.normals.size(); ++i) {
    if (!is_missing(i)) continue;
    constexpr double kCancelled = 1e-9;  // triangles back to back
    mesh.normals[i] = to_float(length(sums[i]) > kCancelled ? direction(sums[i]) : spares[i]);
    if (is_missing(i)) mesh.normals[i] = {0, 0, 1};
  }
}

void reverse(Triangle& t) { std::swap(t[1], t[2]); }

void orient_by_normals(Mesh& mesh) {
  for (Triangle& t : mesh.triangles) {
    const Double3 sum = Double3(mesh.normals[t[0]]) + Double3(mesh.normals[t[1]]) + Double3(mesh.normals[t[2]]);
    if (dot(area_normal(mesh, t), sum) < 0) reverse(t);
  }
}

bool is_degenerate(const Mesh& mesh, const Triangle& t) {
  constexpr double kSmallestDoubleArea = 1e-37;
  constexpr double kSmallestRatio = 0x1p-22;  // of twice the area to the longest edge squared
  for (const std::uint32_t vertex : t) {
    if (vertex >= mesh.positions.size()) return true;
    const Vec3f p = mesh.positions[vertex];
    for (const float c : {p.x, p.y, p.z}) {
      if (!(std::abs(c) <= kMaxMeshCoordinate)) return true;
    }
  }
  double longest_squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Double3 edge = Double3(mesh.positions[t[(k + 1) % 3]]) - Double3(mesh.positions[t[k]]);
    longest_squared = std::max(longest_squared, dot(edge, edge));
  }
  const double double_area = length(area_normal(mesh, t));
  return double_area < kSmallestDoubleArea || double_area < kSmallestRatio * longest_squared;
}

template <class T> void keep(std::vector<T>& values, const std::vector<std::uint32_t>& sources) {
  if (values.empty()) return;
  std::vector<T> kept(sources.size());
  std::transform(sources.begin(), sources.end(), kept.begin(), [&](std::uint32_t source) { return values[source]; });
  values = std::move(kept);
}

void drop_unused_vertices(Mesh& mesh) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> renamed(mesh.positions.size(), kUnused), sources;
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& vertex : t) {
      if (renamed[vertex] == kUnused) {
        renamed[vertex] = static_cast<std::uint32_t>(sources.size());
        sources.push_back(vertex);
      }
      vertex = renamed[vertex];
    }
  }
  keep(mesh.positions, sources);
  keep(mesh.normals, sources);
  keep(mesh.uvs, sources);
}

/// Adds a square face around `centre`, spanned by half edges along u and v. Its front is on the side of `normal`.
void append_square(Mesh& mesh, Vec3f centre, Vec3f normal, Vec3f u, Vec3f v) {
  constexpr std::array<Vec2f, 4> kCorners{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Vec2f corner : kCorners) {
    mesh.positions.push_back(centre + u * (2 * corner.x - 1) + v * (2 * corner.y - 1));
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
    throw SceneError(where, "a mesh has " + std::to_string(length) + " " + what + " for " + std::to_string(count) +
                                " vertices");
  };
  check_length(mesh.normals.size(), "normals");
  check_length(mesh.uvs.size(), "texture coordinates");
  for (const Triangle& t : mesh.triangles) {
    const std::uint32_t highest = std::max({t[0], t[1], t[2]});
    if (highest < count) continue;
    throw SceneError(where, "a triangle refers to vertex " + std::to_string(highest) +
                                " (counted from 0), but there are " + std::to_string(count));
  }
}

void transform_mesh(Mesh& mesh, const Transform& to_world) {
  for (Vec3f& p : mesh.positions) p = to_world.point(p);
  if (mesh.normals.empty()) return;
  for (Vec3f& n : mesh.normals) n = to_float(direction(Double3(to_world.normal(n))));
  if (to_world.swaps_handedness()) {
    for (Triangle& t : mesh.triangles) reverse(t);
  }
  orient_by_normals(mesh);
  fill_zero_normals(mesh);
}

void flip_mesh(Mesh& mesh) {
  for (Triangle& t : mesh.triangles) reverse(t);
  for (Vec3f& n : mesh.normals) n = -n;
}

void compute_vertex_normals(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Vec3f{0, 0, 0});
  fill_zero_normals(mesh);
}

std::size_t drop_degenerate_triangles(Mesh& mesh) {
  const std::size_t dropped = std::erase_if(mesh.triangles, [&](const Triangle& t) { return is_degenerate(mesh, t); });
  if (dropped > 0) drop_unused_vertices(mesh);
  return dropped;
}

}  // namespace sheaf

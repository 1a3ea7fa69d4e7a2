// Vertex normals from smoothing groups or a crease angle, by disjoint sets of triangle corners.
#include "scene/formats/smooth_normals.h"

#include "scene/formats/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <unordered_map>

namespace sheaf {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

struct Direction {
  double x = 0, y = 0, z = 0;
};
Direction operator+(const Direction& a, const Direction& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Direction operator*(const Direction& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double dot(const Direction& a, const Direction& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Direction between(Vec3f from, Vec3f to) {
  return {double{to.x} - double{from.x}, double{to.y} - double{from.y}, double{to.z} - double{from.z}};
}
Direction cross(const Direction& a, const Direction& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Direction unit(const Direction& a) {
  const double length = std::sqrt(dot(a, a));
  return length > 0 && std::isfinite(length) ? a * (1 / length) : Direction{};
}

/// Disjoint-set forest of triangle corners.
class CornerSets {
 public:
  explicit CornerSets(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0u); }

  std::uint32_t find(std::uint32_t corner) {
    while (parents_[corner] != corner) corner = parents_[corner] = parents_[parents_[corner]];
    return corner;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a), b = find(b);
    parents_[std::max(a, b)] = std::min(a, b);  // the first corner represents the set
  }

 private:
  std::vector<std::uint32_t> parents_;
};

/// Joins corners at the same position that belong to the same smoothing group.
void join_groups(const Mesh& mesh, const std::vector<std::uint32_t>& welded_vertices,
                 std::span<const std::uint32_t> groups, CornerSets& sets) {
  std::unordered_map<std::uint64_t, std::uint32_t> first;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (groups[t] == 0) continue;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint64_t key = std::uint64_t{groups[t]} << 32 | welded_vertices[mesh.triangles[t][k]];
      const auto [found, is_new] = first.try_emplace(key, 3 * t + k);
      if (!is_new) sets.join(found->second, 3 * t + k);
    }
  }
}

/// Joins corners across edges that two triangles share, except creases.
void join_across_edges(const Mesh& mesh, const std::vector<std::uint32_t>& welded_vertices,
                       const std::vector<Direction>& normals, CornerSets& sets) {
  struct Edge {
    std::uint64_t ends;  ///< position indices, the lower one first
    std::uint32_t corner;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  const auto welded = [&](std::uint32_t corner) { return welded_vertices[mesh.triangles[corner / 3][corner % 3]]; };
  const auto next = [](std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
  for (std::uint32_t corner = 0; corner < 3 * mesh.triangles.size(); ++corner) {
    const std::uint64_t a = welded(corner), b = welded(next(corner));
    if (a != b) edges.push_back({std::min(a, b) << 32 | std::max(a, b), corner});
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.ends != b.ends ? a.ends < b.ends : a.corner < b.corner; });
  const double smallest = std::cos(double{kCreaseAngle} * std::numbers::pi / 180);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end].ends == edges[i].ends) ++end;
    const bool pair = end == i + 2;
    std::uint32_t a = edges[i].corner, b = pair ? edges[i + 1].corner : a;
    i = end;
    if (!pair || dot(normals[a / 3], normals[b / 3]) < smallest) continue;
    std::uint32_t a_end = next(a), b_end = next(b);
    if (welded(a) != welded(b)) std::swap(b, b_end);
    sets.join(a, b);
    sets.join(a_end, b_end);
  }
}

/// Assigns each vertex the normal of its corners' set; splits vertices whose corners belong to several sets.
void apply(Mesh& mesh, CornerSets& sets, const std::vector<Direction>& normals) {
  // Sum the angle-weighted normals of each set
  std::vector<Direction> sums(3 * mesh.triangles.size());
  for (std::uint32_t corner = 0; corner < sums.size(); ++corner) {
    const Triangle& t = mesh.triangles[corner / 3];
    const Vec3f p = mesh.positions[t[corner % 3]];
    const Direction u = between(p, mesh.positions[t[(corner % 3 + 1) % 3]]),
                    v = between(p, mesh.positions[t[(corner % 3 + 2) % 3]]);
    const Direction across = cross(u, v);
    const double angle = std::atan2(std::sqrt(dot(across, across)), dot(u, v));
    Direction& sum = sums[sets.find(corner)];
    if (std::isfinite(angle)) sum = sum + normals[corner / 3] * angle;
  }
  // Assign normals and split vertices
  constexpr std::uint32_t kUnused = 0xffffffffu;
  std::vector<std::uint32_t> first_set(mesh.positions.size(), kUnused), sources;
  std::vector<Vec3f> copied;
  std::unordered_map<std::uint64_t, std::uint32_t> copies;
  const auto count = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.normals.assign(count, Vec3f{0, 0, 1});
  for (std::uint32_t corner = 0; corner < sums.size(); ++corner) {
    std::uint32_t& vertex = mesh.triangles[corner / 3][corner % 3];
    const std::uint32_t set = sets.find(corner);
    constexpr double kCanceled = 1e-9;  // for triangles back to back
    const bool canceled = !(dot(sums[set], sums[set]) > kCanceled * kCanceled);
    const Direction normal = canceled ? normals[corner / 3] : unit(sums[set]);
    const Vec3f rounded{static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)};
    if (first_set[vertex] == kUnused) {
      first_set[vertex] = set;
      mesh.normals[vertex] = rounded;
    } else if (first_set[vertex] != set) {
      const auto next = static_cast<std::uint32_t>(count + sources.size());
      const auto [found, is_new] = copies.try_emplace(std::uint64_t{vertex} << 32 | set, next);
      if (is_new) {
        if (next == kUnused) throw SceneError("a mesh of more than 2^32 - 1 vertices");
        sources.push_back(vertex);
        copied.push_back(rounded);
      }
      vertex = found->second;
    }
  }
  append_vertex_copies(mesh, sources);
  std::copy(copied.begin(), copied.end(), mesh.normals.begin() + static_cast<std::ptrdiff_t>(count));
}

std::vector<Direction> triangle_normals(const Mesh& mesh) {
  std::vector<Direction> normals;
  normals.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    normals.push_back(unit(cross(between(mesh.positions[t[0]], mesh.positions[t[1]]),
                                 between(mesh.positions[t[0]], mesh.positions[t[2]]))));
  return normals;
}

}  // namespace

void compute_creased_normals(Mesh& mesh, std::span<const std::uint32_t> groups) {
  const std::vector<std::uint32_t> welded_vertices = same_positions(mesh);
  const std::vector<Direction> normals = triangle_normals(mesh);
  CornerSets sets(3 * mesh.triangles.size());
  if (groups.empty()) {
    join_across_edges(mesh, welded_vertices, normals, sets);
  } else {
    join_groups(mesh, welded_vertices, groups, sets);
  }
  apply(mesh, sets, normals);
}

void compute_welded_normals(Mesh& mesh) {
  const std::vector<std::uint32_t> one_group(mesh.triangles.size(), 1);
  compute_creased_normals(mesh, one_group);
}

}  // namespace sheaf

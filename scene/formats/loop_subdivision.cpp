// Loop subdivision with limit positions and normals (Loop 1987; Warren 1995; Hoppe et al. 1994).
#include "scene/formats/loop_subdivision.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace sheaf {

namespace {

struct Point {
  double x = 0, y = 0, z = 0;
  Point operator+(const Point& b) const { return {x + b.x, y + b.y, z + b.z}; }
  Point operator-(const Point& b) const { return {x - b.x, y - b.y, z - b.z}; }
  Point operator*(double s) const { return {x * s, y * s, z * s}; }
};
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

using Triangle = std::array<std::uint32_t, 3>;
constexpr std::uint32_t kNobody = 0xffffffffu;

std::uint64_t directed(std::uint32_t from, std::uint32_t to) { return std::uint64_t{from} << 32 | to; }

/// Adjacency of a triangle mesh.
class Neighbors {
 public:
  Neighbors(const std::vector<Triangle>& triangles, std::size_t vertices)
      : first_(vertices, kNobody), corners_(vertices, 0) {
    across_.reserve(3 * triangles.size());
    for (const Triangle& t : triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
        if (a == b) throw SceneError(fmt::format("a triangle of the control mesh has the vertex {} twice", a));
        if (!across_.emplace(directed(a, b), c).second)
          throw SceneError(
              fmt::format("the edge from vertex {} to {} of the control mesh has several triangles on the same side "
                          "(expected one or two of the same orientation)",
                          a, b));
        if (first_[a] == kNobody) first_[a] = b;
        ++corners_[a];
      }
  }

  /// Returns the vertex to the left of a directed edge, or kNobody without a triangle there.
  std::uint32_t left(std::uint32_t a, std::uint32_t b) const {
    const auto found = across_.find(directed(a, b));
    return found != across_.end() ? found->second : kNobody;
  }

  /// One-ring of a vertex in counter-clockwise order; on the boundary, from one end to the other.
  struct Ring {
    std::vector<std::uint32_t> vertices;
    bool closed = true;
  };
  Ring ring(std::uint32_t vertex) const {
    Ring out;
    const std::uint32_t start = first_[vertex];
    if (start == kNobody) return out;
    // Walk back to the start of the boundary.
    std::uint32_t begin = start;
    for (;;) {
      const std::uint32_t before = left(begin, vertex);
      if (before == start) break;
      if (before == kNobody) {
        out.closed = false;
        break;
      }
      begin = before;
    }
    if (out.closed) begin = start;
    std::uint32_t at = begin;
    do {
      out.vertices.push_back(at);
      at = left(vertex, at);
    } while (at != kNobody && at != begin);
    const std::size_t corners = out.vertices.size() - (out.closed ? 0 : 1);
    if (corners != corners_[vertex])
      throw SceneError(fmt::format("vertex {} of the control mesh joins parts that share no edge there", vertex));
    return out;
  }

 private:
  std::unordered_map<std::uint64_t, std::uint32_t> across_;  ///< by directed edge: the vertex to its left
  std::vector<std::uint32_t> first_;                         ///< one neighbor of each vertex
  std::vector<std::size_t> corners_;                         ///< number of triangles at each vertex
};

/// Weight of each neighbor in the vertex rule for valence k (Warren 1995).
double neighbor_weight(std::size_t k) { return k == 3 ? 3.0 / 16 : 3.0 / (8 * static_cast<double>(k)); }

/// Applies a vertex rule: each neighbor has the weight `inner`; on the boundary, each boundary neighbor has
/// `boundary`.
Point moved(const std::vector<Point>& points, std::uint32_t vertex, const Neighbors::Ring& ring, double inner,
            double boundary) {
  if (ring.vertices.empty()) return points[vertex];
  if (!ring.closed)
    return points[vertex] * (1 - 2 * boundary) +
           (points[ring.vertices.front()] + points[ring.vertices.back()]) * boundary;
  Point sum;
  for (const std::uint32_t n : ring.vertices) sum = sum + points[n];
  return points[vertex] * (1 - inner * static_cast<double>(ring.vertices.size())) + sum * inner;
}

void refine(std::vector<Point>& points, std::vector<Triangle>& triangles) {
  const Neighbors neighbors(triangles, points.size());
  std::vector<Point> out(points.size());
  // Move the old vertices
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    const Neighbors::Ring ring = neighbors.ring(v);
    out[v] = moved(points, v, ring, neighbor_weight(ring.vertices.size()), 1.0 / 8);
  }
  // Add a vertex per edge
  std::unordered_map<std::uint64_t, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [found, is_new] =
        middles.emplace(directed(std::min(a, b), std::max(a, b)), static_cast<std::uint32_t>(out.size()));
    if (!is_new) return found->second;
    const std::uint32_t left = neighbors.left(a, b), right = neighbors.left(b, a);
    const Point ends = points[a] + points[b];
    out.push_back(left == kNobody || right == kNobody ? ends * 0.5
                                                      : ends * 0.375 + (points[left] + points[right]) * 0.125);
    return found->second;
  };
  // Split each triangle into four
  std::vector<Triangle> finer;
  finer.reserve(4 * triangles.size());
  for (const auto& [a, b, c] : triangles) {
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  points = std::move(out);
  triangles = std::move(finer);
}

/// Returns the tangent across the boundary, up to a factor (Hoppe et al. 1994, appendix A).
Point across_boundary(const std::vector<Point>& points, std::uint32_t vertex, const std::vector<std::uint32_t>& ring) {
  const auto at = [&](std::size_t j) { return points[ring[j]]; };
  const std::size_t k = ring.size();
  if (k == 2) return at(0) + at(1) - points[vertex] * 2;
  if (k == 3) return at(1) - points[vertex];
  if (k == 4) return (at(1) + at(2)) * 2 - at(0) - at(3) - points[vertex] * 2;
  const double angle = std::acos(-1.0) / static_cast<double>(k - 1);
  Point sum = (at(0) + at(k - 1)) * std::sin(angle);
  for (std::size_t j = 1; j + 1 < k; ++j)
    sum = sum + at(j) * ((2 * std::cos(angle) - 2) * std::sin(static_cast<double>(j) * angle));
  return sum;
}

/// Returns the normal of the limit surface at a vertex, not normalized; zero if undefined.
Point limit_normal(const std::vector<Point>& points, std::uint32_t vertex, const Neighbors::Ring& ring) {
  const std::vector<std::uint32_t>& around = ring.vertices;
  const std::size_t k = around.size();
  if (k < 2) return {};
  Point first, second, facing;
  for (std::size_t j = 0; j < k; ++j) {
    const double angle = 2 * std::acos(-1.0) * static_cast<double>(j) / static_cast<double>(k);
    first = first + points[around[j]] * std::cos(angle);
    second = second + points[around[j]] * std::sin(angle);
    if (ring.closed || j + 1 < k)
      facing = facing + cross(points[around[j]] - points[vertex], points[around[(j + 1) % k]] - points[vertex]);
  }
  if (!ring.closed) {
    first = points[around.back()] - points[around.front()];
    second = across_boundary(points, vertex, around);
  }
  const Point normal = cross(first, second);
  return dot(normal, facing) < 0 ? normal * -1 : normal;
}

Vec3f to_float(const Point& p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }

}  // namespace

Mesh subdivide(const Mesh& control, int levels) {
  std::vector<Point> points;
  for (const Vec3f p : control.positions) points.push_back({double{p.x}, double{p.y}, double{p.z}});
  std::vector<Triangle> triangles = control.triangles;
  if (triangles.size() > kMaxSubdivided >> (2 * levels))
    throw SceneError(fmt::format("the surface would have more than {} triangles", kMaxSubdivided));
  for (int level = 0; level < levels; ++level) refine(points, triangles);
  // Project the vertices to the limit surface
  const Neighbors neighbors(triangles, points.size());
  Mesh out;
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    const Neighbors::Ring ring = neighbors.ring(v);
    const double inner =
        1 / (static_cast<double>(ring.vertices.size()) + 3 / (8 * neighbor_weight(ring.vertices.size())));
    out.positions.push_back(to_float(moved(points, v, ring, inner, 1.0 / 6)));
    const Point normal = limit_normal(points, v, ring);
    const double length = std::sqrt(dot(normal, normal));
    out.normals.push_back(length > 0 ? to_float(normal * (1 / length)) : Vec3f{0, 0, 0});
  }
  out.triangles = std::move(triangles);
  return out;
}

}  // namespace sheaf

// Triangulation by ear clipping in double precision, on the coordinate plane of the polygon's largest projection.
#include "scene/formats/triangulate.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

struct Point {
  double x, y;
};

/// Returns twice the signed area of the triangle a b c, positive if counter-clockwise.
double cross(Point a, Point b, Point c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// Projects the polygon to the coordinate plane where its area is largest, in counter-clockwise order. Empty if it has
/// no finite area.
std::vector<Point> project(std::span<const Vec3f> corners) {
  const Vec3f origin = corners[0];
  const auto coordinates = [&](std::size_t i) {
    return std::array<double, 3>{double(corners[i].x) - origin.x, double(corners[i].y) - origin.y,
                                 double(corners[i].z) - origin.z};
  };
  // Compute the normal
  std::array<double, 3> normal{};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto a = coordinates(i), b = coordinates((i + 1) % corners.size());
    for (std::size_t k = 0; k < 3; ++k) normal[k] += a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
  }
  // Choose the coordinate plane
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
  }
  if (normal[axis] == 0 || !std::isfinite(normal[0] + normal[1] + normal[2])) return {};
  // Project, keeping the orientation
  std::vector<Point> points(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto c = coordinates(i);
    const double u = c[(axis + 1) % 3], v = c[(axis + 2) % 3];
    points[i] = normal[axis] > 0 ? Point{u, v} : Point{v, u};
  }
  return points;
}

/// Whether no corner turns right and the outline winds around once, in which case its x coordinate reverses only twice.
bool is_convex(const std::vector<Point>& p) {
  const std::size_t n = p.size();
  int reversals = 0;
  double last_step = 0, first_step = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point a = p[i], b = p[(i + 1) % n], c = p[(i + 2) % n];
    if (cross(a, b, c) < 0) return false;
    const double step = b.x - a.x;
    if (step == 0) continue;
    if (last_step * step < 0) ++reversals;
    if (first_step == 0) first_step = step;
    last_step = step > 0 ? 1 : -1;
  }
  if (last_step * first_step < 0) ++reversals;
  return reversals <= 2;
}

void append_fan(std::span<const std::uint32_t> corners, std::vector<PolygonTriangle>& out) {
  for (std::size_t i = 2; i < corners.size(); ++i) out.push_back({corners[0], corners[i - 1], corners[i]});
}

/// The remaining outline: a doubly linked ring of corners.
class Ring {
 public:
  explicit Ring(const std::vector<Point>& points) : points_(points), next_(points.size()), previous_(points.size()) {
    const auto n = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
  }

  std::uint32_t next(std::uint32_t i) const { return next_[i]; }
  std::uint32_t previous(std::uint32_t i) const { return previous_[i]; }
  double cross_at(std::uint32_t i) const { return cross(points_[previous_[i]], points_[i], points_[next_[i]]); }

  /// Whether the triangle at corner i contains no other corner of the ring. Adds the number of visited corners to
  /// `work`.
  bool is_empty_at(std::uint32_t i, std::size_t& work) const {
    const Point a = points_[previous_[i]], b = points_[i], c = points_[next_[i]];
    for (std::uint32_t k = next_[next_[i]]; k != previous_[i]; k = next_[k]) {
      ++work;
      const Point p = points_[k];
      const auto is_at = [&](Point q) { return p.x == q.x && p.y == q.y; };
      if (is_at(a) || is_at(b) || is_at(c)) continue;
      if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) return false;
    }
    return true;
  }

  void remove(std::uint32_t i) {
    next_[previous_[i]] = next_[i];
    previous_[next_[i]] = previous_[i];
  }

 private:
  const std::vector<Point>& points_;
  std::vector<std::uint32_t> next_, previous_;
};

bool clip_ears(const std::vector<Point>& points, std::vector<PolygonTriangle>& out) {
  constexpr std::size_t kMaxWork = 100'000'000;  // corner tests, about 0.2 s; a limit for adversarial outlines
  Ring ring(points);
  std::size_t left = points.size(), since_last_ear = 0, work = 0;
  std::uint32_t i = 0;
  while (left > 3 && since_last_ear <= left && work < kMaxWork) {
    ++since_last_ear;
    ++work;
    const double signed_area = ring.cross_at(i);
    if (signed_area == 0 || (signed_area > 0 && ring.is_empty_at(i, work))) {
      if (signed_area > 0) out.push_back({ring.previous(i), i, ring.next(i)});
      ring.remove(i);
      --left;
      since_last_ear = 0;
    }
    i = ring.next(i);
  }
  std::vector<std::uint32_t> rest;
  for (std::size_t k = 0; k < left; ++k, i = ring.next(i)) rest.push_back(i);
  append_fan(rest, out);
  return left == 3;
}

}  // namespace

bool triangulate_polygon(std::span<const Vec3f> corners, std::vector<PolygonTriangle>& out) {
  out.clear();
  if (corners.size() > 3) {
    const std::vector<Point> points = project(corners);
    if (!points.empty() && !is_convex(points)) return clip_ears(points, out);
  }
  for (std::uint32_t i = 2; i < corners.size(); ++i) out.push_back({0, i - 1, i});
  return true;
}

}  // namespace sheaf

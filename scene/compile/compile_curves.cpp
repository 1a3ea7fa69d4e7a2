// Compiles curves.
#include "scene/compile/scene_compiler.h"

#include <cmath>

namespace sheaf {

namespace {

/// Maximum coordinate: Embree intersects tubes in single precision, with products of four lengths.
constexpr float kMaxCurveCoordinate = 1e9f;
/// Embree's intersection of lines treats differences of products of four lengths as 0 below a constant.
constexpr float kShortLine = 5e-3f;

/// Minimum radius of the convex hull of a cubic B-spline segment whose control points start at `p`, from its Bezier
/// form. Radii that shrink linearly to zero have a negative control radius beyond the end.
float min_radius(const Curves::Point* p) {
  const float a = p[0].radius, b = p[1].radius, c = p[2].radius, d = p[3].radius;
  return std::min({(a + 4 * b + c) / 6, (2 * b + c) / 3, (b + 2 * c) / 3, (b + 4 * c + d) / 6});
}

/// Throws SceneError for negative radii.
void check_radii(const Curves& curves, std::size_t begin, std::size_t end) {
  constexpr float kRounding = 1e-5f;
  for (std::size_t i = begin; i + curves.order() <= end; ++i) {
    const Curves::Point* p = curves.points.data() + i;
    const bool linear = curves.basis == Curves::Basis::kLinear;
    const float smallest = linear ? std::min(p[0].radius, p[1].radius) : min_radius(p);
    const float largest = std::max(p[linear ? 0 : 1].radius, p[linear ? 1 : 2].radius);
    if (!(smallest >= -kRounding * std::max(largest, 0.0f)))
      throw SceneError("the radius of a curve is " + std::to_string(smallest));
  }
}

/// Throws SceneError for properties that curves do not support.
void check_curves(const ShapeDescription& shape, const Curves& curves) {
  if (shape.radiance) throw SceneError("curves cannot emit light (expected no <emitter>)");
  if (shape.interior || shape.exterior)
    throw SceneError("curves cannot bound media (expected neither 'interior' nor 'exterior')");
  if (shape.flip_normals) throw SceneError("the normals of curves point outwards (expected no 'flip_normals')");
  if (curves.points.empty() || curves.starts.empty() || curves.starts.front() != 0)
    throw SceneError("the curves have no points");
  for (std::size_t i = 0; i < curves.starts.size(); ++i) {
    const std::size_t end = i + 1 < curves.starts.size() ? curves.starts[i + 1] : curves.points.size();
    if (end > curves.points.size() || end < std::size_t{curves.starts[i]} + curves.order())
      throw SceneError("a curve has fewer than " + std::to_string(curves.order()) + " points");
    check_radii(curves, curves.starts[i], end);
  }
}

/// Segments that can be intersected, given by their first points.
struct UsableSegments {
  std::vector<std::uint32_t> first;
  std::size_t left_out = 0, short_lines = 0;
  GridBox box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
};

UsableSegments usable_segments(const Curves& curves, const std::vector<CurvePointRow>& points) {
  const std::uint32_t order = curves.order();
  UsableSegments out;
  for (std::size_t i = 0; i < curves.starts.size(); ++i) {
    const auto end = static_cast<std::uint32_t>(i + 1 < curves.starts.size() ? curves.starts[i + 1] : points.size());
    for (std::uint32_t first = curves.starts[i]; first + order <= end; ++first) {
      // Bound the control points
      GridBox around{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
      float radius = 0;
      bool usable = true;
      for (std::uint32_t k = first; k < first + order; ++k) {
        const CurvePointRow& point = points[k];
        usable = usable && is_finite(point.position) &&
                 max_component(abs(point.position)) + std::fabs(point.radius) <= kMaxCurveCoordinate;
        radius = std::max(radius, point.radius);
        grow_box(around.min, around.max, point.position, point.position);
      }
      // Skip segments that cannot be intersected
      if (!usable || !(radius > 0.0f) || around.min == around.max) {
        ++out.left_out;
        continue;
      }
      const Vec3f margin{radius, radius, radius};
      grow_box(out.box.min, out.box.max, around.min - margin, around.max + margin);
      out.first.push_back(first);
      out.short_lines += order == 2 && length(around.max - around.min) < kShortLine;
    }
  }
  return out;
}

}  // namespace

void SceneCompiler::add_curves(ShapeRow row, const ShapeDescription& shape, const Curves& curves) {
  check_curves(shape, curves);
  if (4 * (out_->geometry_.curve_points.size() + curves.points.size()) > kMaxWords)
    throw SceneError("more than " + std::to_string(kMaxWords / 4) + " points of curves in all");
  // Transform the control points
  std::vector<CurvePointRow> points;
  points.reserve(curves.points.size());
  for (const Curves::Point& point : curves.points)
    points.push_back({shape.to_world.point(point.position), point.radius});

  // Find the usable segments, and report the others
  const UsableSegments segments = usable_segments(curves, points);
  if (segments.left_out > 0)
    warn(shape, std::to_string(segments.left_out) + " degenerate or non-finite curve segments left out");
  if (segments.short_lines > 0)
    warn(
        shape,
        std::to_string(segments.short_lines) +
            " line segments are shorter than 0.005 units, too short for exact intersections (expected a larger scale)");
  if (segments.first.empty()) {
    warn(shape, "the curves have no surface: left out");
    return;
  }
  // Append points, segments and shape
  grow(segments.box.min, segments.box.max);
  row.kind = static_cast<std::uint32_t>(curves.basis == Curves::Basis::kLinear ? ShapeKind::kLinearCurves
                                                                               : ShapeKind::kBsplineCurves);
  row.first_vertex = static_cast<std::uint32_t>(out_->geometry_.curve_points.size());
  row.first_triangle = static_cast<std::uint32_t>(out_->geometry_.curve_segments.size());
  row.triangle_count = static_cast<std::uint32_t>(segments.first.size());
  out_->geometry_.curve_points.insert(out_->geometry_.curve_points.end(), points.begin(), points.end());
  out_->geometry_.curve_segments.insert(out_->geometry_.curve_segments.end(), segments.first.begin(),
                                        segments.first.end());
  vertex_counts_.push_back(static_cast<std::uint32_t>(points.size()));
  out_->counts_.curve_segments += segments.first.size();
  push_shape(row, shape, segments.box);
}

}  // namespace sheaf

// Adds curves to the geometry of a scene.
#include "scene/compile/geometry/compiled_geometry.h"
#include "scene/compile/key_times.h"

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
      throw SceneError(fmt::format("the radius of a curve is {}", smallest));
  }
}

/// Throws SceneError for properties that curves do not support.
void check_shape(const ShapeDescription& shape) {
  if (shape.radiance) throw SceneError("curves cannot emit light (expected no <emitter>)");
  if (shape.interior || shape.exterior)
    throw SceneError("curves cannot bound media (expected neither 'interior' nor 'exterior')");
  if (shape.flip_normals) throw SceneError("the normals of curves point outwards (expected no 'flip_normals')");
}

/// Throws SceneError for curves without points or with invalid radii.
void check_curves(const Curves& curves) {
  if (curves.points.empty() || curves.starts.empty() || curves.starts.front() != 0)
    throw SceneError("the curves have no points");
  for (std::size_t i = 0; i < curves.starts.size(); ++i) {
    const std::size_t end = i + 1 < curves.starts.size() ? curves.starts[i + 1] : curves.points.size();
    if (end > curves.points.size() || end < std::size_t{curves.starts[i]} + curves.order())
      throw SceneError(fmt::format("a curve has fewer than {} points", curves.order()));
    check_radii(curves, curves.starts[i], end);
  }
}

/// Throws SceneError unless the curves have the same number of points each.
void check_same_topology(const Curves& first, const Curves& later, std::size_t number) {
  const auto differ = [&](const char* what, std::size_t a, std::size_t b) {
    throw SceneError(fmt::format("the curves of a deformation differ in their {}: number 1 has {}, number {} has {}",
                                 what, a, number, b));
  };
  if (first.basis != later.basis)
    throw SceneError(fmt::format("the curves of a deformation are of different types: numbers 1 and {}", number));
  if (first.starts.size() != later.starts.size()) differ("number of curves", first.starts.size(), later.starts.size());
  if (first.points.size() != later.points.size()) differ("points", first.points.size(), later.points.size());
  if (first.starts != later.starts)
    throw SceneError(
        fmt::format("the curves of a deformation differ in the points per curve: numbers 1 and {}", number));
}

using CurveStep = std::vector<CurvePointRow>;

CurveStep transformed(const Curves& curves, const Transform& to_world) {
  CurveStep points;
  points.reserve(curves.points.size());
  for (const Curves::Point& point : curves.points) points.push_back({to_world.point(point.position), point.radius});
  return points;
}

/// A segment at one time.
struct SegmentBounds {
  Bounds3f box = Bounds3f::empty();  ///< of the control points
  float radius = 0;                  ///< the largest one
  bool is_finite = true;             ///< else it cannot be traced

  bool has_surface() const { return radius > 0.0f && box.min != box.max; }
};

SegmentBounds bounds_of(const CurvePointRow* points, std::uint32_t order) {
  SegmentBounds out;
  for (const CurvePointRow* point = points; point < points + order; ++point) {
    out.is_finite = out.is_finite && is_finite(point->position) &&
                    max_component(abs(point->position)) + std::fabs(point->radius) <= kMaxCurveCoordinate;
    out.radius = std::max(out.radius, point->radius);
    out.box.grow(point->position);
  }
  return out;
}

/// Segments that can be intersected, given by their first points.
struct UsableSegments {
  std::vector<std::uint32_t> first;
  std::size_t left_out = 0, short_lines = 0;
};

/// The segments that can be traced at all times and have a surface at one of them. `keys`: the control points at each
/// time.
UsableSegments usable_segments(const Curves& curves, const std::vector<CurveStep>& keys) {
  const std::uint32_t order = curves.order();
  UsableSegments out;
  for (std::size_t i = 0; i < curves.starts.size(); ++i) {
    const auto end =
        static_cast<std::uint32_t>(i + 1 < curves.starts.size() ? curves.starts[i + 1] : curves.points.size());
    for (std::uint32_t first = curves.starts[i]; first + order <= end; ++first) {
      bool is_finite = true, has_surface = false, is_short = false;
      for (const CurveStep& points : keys) {
        const SegmentBounds bounds = bounds_of(points.data() + first, order);
        is_finite = is_finite && bounds.is_finite;
        has_surface = has_surface || bounds.has_surface();
        is_short = is_short || (order == 2 && length(bounds.box.max - bounds.box.min) < kShortLine);
      }
      if (!is_finite || !has_surface) {
        ++out.left_out;
        continue;
      }
      out.first.push_back(first);
      out.short_lines += is_short;
    }
  }
  return out;
}

/// Bounds of the segments at all steps; in between they are in their convex hull.
Bounds3f bounds_of(const UsableSegments& segments, const std::vector<CurveStep>& steps, std::uint32_t order) {
  Bounds3f box = Bounds3f::empty();
  for (const CurveStep& points : steps)
    for (const std::uint32_t first : segments.first) {
      const SegmentBounds bounds = bounds_of(points.data() + first, order);
      const Vec3f margin{bounds.radius, bounds.radius, bounds.radius};
      box.grow({bounds.box.min - margin, bounds.box.max + margin});
    }
  return box;
}

/// The control points between two keys.
CurveStep points_at(const std::vector<CurveStep>& keys, const KeyInterval& interval) {
  CurveStep out = keys[interval.before];
  if (interval.before == interval.after) return out;
  const CurveStep& after = keys[interval.after];
  const float t = interval.t;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = {out[i].position * (1 - t) + after[i].position * t, out[i].radius * (1 - t) + after[i].radius * t};
  return out;
}

bool differ(const CurveStep& a, const CurveStep& b) {
  return !std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const CurvePointRow& p, const CurvePointRow& q) {
    return p.position == q.position && p.radius == q.radius;
  });
}

/// Adds curves at equidistant times over the shutter. `keys`: the same at all times at which they are given.
std::optional<AddedShape> add_curve_steps(const ShapeDescription& shape, const Curves& curves,
                                          const std::vector<CurveStep>& keys, const std::vector<CurveStep>& steps,
                                          MotionCompiler& motion, CompiledGeometry& out) {
  std::vector<CurvePointRow>& all = out.tables.curve_points;
  if (4 * (all.size() + steps.size() * curves.points.size()) > kMaxTableWords)
    throw SceneError(fmt::format("more than {} points of curves in all", kMaxTableWords / 4));
  // Find the usable segments, and report the others
  const UsableSegments segments = usable_segments(curves, keys);
  if (segments.left_out > 0)
    out.warn(shape, fmt::format("{} degenerate or non-finite curve segments left out", segments.left_out));
  if (segments.short_lines > 0)
    out.warn(shape, fmt::format("{} line segments are shorter than 0.005 units, too short for exact intersections "
                                "(expected a larger scale)",
                                segments.short_lines));
  if (segments.first.empty()) {
    out.warn(shape, "the curves have no surface: left out");
    return std::nullopt;
  }
  // Append points and segments
  AddedShape added{{}, bounds_of(segments, steps, curves.order()), static_cast<std::uint32_t>(curves.points.size())};
  ShapeRow& row = added.row;
  std::vector<std::uint32_t>& all_segments = out.tables.curve_segments;
  row.kind = static_cast<std::uint32_t>(curves.basis == Curves::Basis::kLinear ? ShapeKind::kLinearCurves
                                                                               : ShapeKind::kBsplineCurves);
  row.first_vertex = static_cast<std::uint32_t>(all.size());
  row.first_triangle = static_cast<std::uint32_t>(all_segments.size());
  row.triangle_count = static_cast<std::uint32_t>(segments.first.size());
  for (const CurveStep& step : steps) all.insert(all.end(), step.begin(), step.end());
  if (steps.size() > 1) row.flags |= motion.add_deformation(steps.size() - 1, curves.points.size());
  all_segments.insert(all_segments.end(), segments.first.begin(), segments.first.end());
  out.info.curve_segments += segments.first.size();
  return added;
}

}  // namespace

std::optional<AddedShape> add_curves(const ShapeDescription& shape, const Curves& curves, MotionCompiler& motion,
                                     CompiledGeometry& out) {
  check_shape(shape);
  check_curves(curves);
  const std::vector<CurveStep> steps{transformed(curves, shape.to_world)};
  return add_curve_steps(shape, curves, steps, steps, motion, out);
}

std::optional<AddedShape> add_curves(const ShapeDescription& shape, const DeformingCurves& from, MotionCompiler& motion,
                                     CompiledGeometry& out) {
  check_shape(shape);
  // Transform the keys
  std::vector<CurveStep> keys;
  std::vector<double> times;
  for (const DeformingCurves::Key& key : from.keys) {
    check_curves(key.curves);
    keys.push_back(transformed(key.curves, shape.to_world * key.to_shape));
    times.push_back(key.time);
    check_same_topology(from.keys[0].curves, key.curves, keys.size());
  }
  // Tabulate the control points over the shutter
  std::vector<CurveStep> steps;
  bool changes = false;
  for (const double time : step_times(times, motion.shutter())) {
    steps.push_back(points_at(keys, interval_at(times, time)));
    changes = changes || differ(steps[0], steps.back());
  }
  if (!changes) steps.resize(1);
  return add_curve_steps(shape, from.keys[0].curves, keys, steps, motion, out);
}

}  // namespace sheaf

// The pbrt dialect: curves. Curves of all types become round tubes along uniform cubic B-splines, because these
// represent every segment of degree 2 or 3 exactly.
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf::pbrt {

namespace {

using Segment = std::array<Vec3f, 4>;

/// Converts the control points of a cubic Bezier curve to those of the identical B-spline segment.
Segment bspline_of(const Segment& b) {
  return {b[0] * 6.0f - b[1] * 7.0f + b[2] * 2.0f, b[1] * 2.0f - b[2], b[2] * 2.0f - b[1],
          b[1] * 2.0f - b[2] * 7.0f + b[3] * 6.0f};
}

/// Raises a quadratic Bezier curve to degree 3.
Segment elevated(Vec3f a, Vec3f b, Vec3f c) { return {a, (a + b * 2.0f) * (1.0f / 3), (b * 2.0f + c) * (1.0f / 3), c}; }

/// Interpretation of a curve's control points.
struct Form {
  bool is_bspline;
  std::size_t degree, segments;
};

Form read_form(Parameters& p, std::size_t points) {
  static constexpr NameTable<bool> kBases{{{"bezier", false}, {"bspline", true}}};
  const bool is_bspline = p.choice("basis", kBases, false);
  Form form{is_bspline, static_cast<std::size_t>(p.integer("degree", 3, 2, 3)), 0};
  if (points <= form.degree)
    p.fail_at("P",
              fmt::format("has {} points, expected {} or more for degree {}", points, form.degree + 1, form.degree));
  if (!form.is_bspline && (points - 1) % form.degree != 0)
    p.fail_at("P", fmt::format("has {} points, expected 1 and a multiple of the degree, {}", points, form.degree));
  form.segments = form.is_bspline ? points - form.degree : (points - 1) / form.degree;
  return form;
}

/// Returns segment `i` as a cubic B-spline segment.
Segment segment_of(const Form& form, const std::vector<Vec3f>& points, std::size_t i) {
  const Vec3f* at = points.data() + (form.is_bspline ? i : i * form.degree);
  if (form.degree == 3) {
    const Segment segment{at[0], at[1], at[2], at[3]};
    return form.is_bspline ? segment : bspline_of(segment);
  }
  return bspline_of(form.is_bspline ? elevated((at[0] + at[1]) * 0.5f, at[1], (at[1] + at[2]) * 0.5f)
                                    : elevated(at[0], at[1], at[2]));
}

/// Returns the factor by which the current transform scales widths: the geometric mean over the three axes.
float width_scale(Parameters& p, const Transform& to_world) {
  const float lengths[] = {length(to_world.vector({1, 0, 0})), length(to_world.vector({0, 1, 0})),
                           length(to_world.vector({0, 0, 1}))};
  const auto [smallest, largest] = std::minmax_element(std::begin(lengths), std::end(lengths));
  if (*largest > 1.001f * *smallest)
    p.reader().note_once(p.where(),
                         p.title() + " is stretched: its width is scaled by the geometric mean over the axes");
  return std::cbrt(lengths[0] * lengths[1] * lengths[2]);
}

void read_type(Parameters& p) {
  static constexpr NameTable<bool> kIsRound{{{"flat", false}, {"ribbon", false}, {"cylinder", true}}};
  const bool is_round = p.choice("type", kIsRound, false);
  if (!is_round)
    p.reader().note_once(p.where(), fmt::format("{} of type '{}' rendered as a round tube of its width", p.title(),
                                                p.string("type", "flat")));
  p.ignore({"N", "splitdepth"});
}

}  // namespace

Curves read_curve(Parameters& p, const Transform& to_world) {
  const std::vector<float> numbers = p.numbers("P", 3);
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    points.push_back(to_world.point({numbers[i], numbers[i + 1], numbers[i + 2]}));
  const Form form = read_form(p, points.size());
  read_type(p);
  const float width = p.number("width", 1, kNotNegative), scale = 0.5f * width_scale(p, to_world);
  const float first = p.number("width0", width, kNotNegative) * scale,
              last = p.number("width1", width, kNotNegative) * scale;

  Curves curves;
  for (std::size_t i = 0; i < form.segments; ++i) {
    const Segment segment = segment_of(form, points, i);
    // Consecutive segments of a cubic B-spline share three points.
    const bool shares_points = i > 0 && form.is_bspline && form.degree == 3;
    if (!shares_points) curves.starts.push_back(static_cast<std::uint32_t>(curves.points.size()));
    for (std::size_t k = shares_points ? 3 : 0; k < 4; ++k) {
      // Radii that interpolate linearly under the B-spline basis, extrapolated beyond both ends.
      const float along = (static_cast<float>(i) + static_cast<float>(k) - 1.0f) / static_cast<float>(form.segments);
      curves.points.push_back({segment[k], first + along * (last - first)});
    }
  }
  return curves;
}

bool append_curve(std::vector<ShapeDescription>& shapes, const ShapeDescription& shape) {
  if (shapes.empty()) return false;
  auto* into = std::get_if<Curves>(&shapes.back().geometry);
  const auto* from = std::get_if<Curves>(&shape.geometry);
  if (into == nullptr || from == nullptr || shapes.back().material != shape.material ||
      shapes.back().motion != shape.motion)
    return false;
  const auto offset = static_cast<std::uint32_t>(into->points.size());
  for (const std::uint32_t start : from->starts) into->starts.push_back(offset + start);
  into->points.insert(into->points.end(), from->points.begin(), from->points.end());
  return true;
}

}  // namespace sheaf::pbrt

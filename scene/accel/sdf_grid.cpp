#include "scene/accel/sdf_grid.h"

#include "core/math/vec3d.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf {

namespace {

Triple apply(const float* m, Vec3f v, double w) {
  Triple r;
  for (std::size_t i = 0; i < 3; ++i)
    r[i] = double(m[4 * i]) * double(v.x) + double(m[4 * i + 1]) * double(v.y) + double(m[4 * i + 2]) * double(v.z) +
           double(m[4 * i + 3]) * w;
  return r;
}

/// Index of a cell's minimum corner along each axis.
std::array<std::uint32_t, 3> corner_of(const SdfGridView& view, std::uint32_t cell) {
  const std::uint32_t* words = view.cells + 2 * std::size_t{cell};
  return {words[0] & 0xffffu, words[0] >> 16, words[1]};
}
Triple to_double(const std::array<std::uint32_t, 3>& corner) {
  return {double(corner[0]), double(corner[1]), double(corner[2])};
}

/// Values at a cell's corners, in the order x + 2 y + 4 z.
struct Corners {
  double v[8];

  Corners(const SdfGridRow& grid, const float* values, const std::array<std::uint32_t, 3>& corner) {
    const std::size_t row = grid.size_x, layer = row * grid.size_y;
    const float* first = values + corner[2] * layer + corner[1] * row + corner[0];
    for (std::size_t i = 0; i < 8; ++i) v[i] = double(first[(i & 1) + (i >> 1 & 1) * row + (i >> 2) * layer]);
  }

  static double mix(double a, double b, double t) { return (1 - t) * a + t * b; }

  /// Trilinear interpolation at a point in [0, 1]^3. If a coordinate is 0 or 1, the values on the other side have no
  /// influence, not even by rounding.
  double at(const Triple& x) const {
    double y[4];
    for (std::size_t i = 0; i < 4; ++i) y[i] = mix(v[2 * i], v[2 * i + 1], x[0]);
    return mix(mix(y[0], y[1], x[1]), mix(y[2], y[3], x[1]), x[2]);
  }

  Triple gradient(const Triple& x) const {
    Triple g;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Triple low = x, high = x;
      low[axis] = 0, high[axis] = 1;
      g[axis] = at(high) - at(low);
    }
    return g;
  }
};

/// A cubic polynomial in the ray parameter, relative to the point where the ray enters the cell.
struct Cubic {
  double c[4] = {};

  /// The trilinear function along o + s d: each corner's value times a product of three linear functions.
  Cubic(const Corners& corners, const Triple& o, const Triple& d) {
    for (std::size_t i = 0; i < 8; ++i) {
      double product[4] = {corners.v[i], 0, 0, 0};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool high = (i >> axis & 1) != 0;
        const double a = high ? o[axis] : 1 - o[axis], b = high ? d[axis] : -d[axis];
        for (std::size_t k = 3; k > 0; --k) product[k] = product[k] * a + product[k - 1] * b;
        product[0] *= a;
      }
      for (std::size_t k = 0; k < 4; ++k) c[k] += product[k];
    }
  }

  double at(double s) const { return ((c[3] * s + c[2]) * s + c[1]) * s + c[0]; }
  double slope(double s) const { return (3 * c[3] * s + 2 * c[2]) * s + c[1]; }

  /// Extrema within (0, end), in order.
  int extrema(double end, double* s) const {
    const double a = 3 * c[3], b = c[2], discriminant = b * b - a * c[1];
    if (!(discriminant > 0)) return 0;
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    double roots[2] = {q / a, c[1] / q};
    if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
    int count = 0;
    for (const double root : roots)
      if (root > 0 && root < end) s[count++] = root;
    return count;
  }

  /// Root between `a` and `b`, where the values `fa` and `fb` have different signs and no extremum lies in between.
  /// Newton's method, safeguarded by bisection.
  double root(double a, double b, double fa, double fb) const {
    double s = a + (b - a) * (fa / (fa - fb));
    for (int i = 0; i < 60; ++i) {
      if (!(s > a && s < b)) s = 0.5 * (a + b);
      const double f = at(s);
      if (f == 0) return s;
      ((f < 0) == (fa < 0) ? a : b) = s;
      const double next = s - f / slope(s);
      if (std::fabs(next - s) <= 1e-15 * b) return std::clamp(next, a, b);
      if (b - a <= 1e-15 * b) return s;
      s = next;
    }
    return s;
  }
};

/// The interval of a ray inside a cell, with the axes of the entry and exit faces; -1 if the ray starts or ends inside.
struct Passage {
  double begin, end;
  int in = -1, out = -1;

  /// `o`, `d`: in units of the grid. Neighboring cells compute identical parameters for their common face.
  Passage(const Triple& o, const Triple& d, const Triple& corner, double t_near, double t_far)
      : begin(t_near), end(t_far) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (d[axis] == 0) {
        if (o[axis] < corner[axis] || o[axis] > corner[axis] + 1) end = -kInfinity;
        continue;
      }
      double first = (corner[axis] - o[axis]) / d[axis], second = (corner[axis] + 1 - o[axis]) / d[axis];
      if (d[axis] < 0) std::swap(first, second);
      if (first > begin) begin = first, in = static_cast<int>(axis);
      if (second < end) end = second, out = static_cast<int>(axis);
    }
  }
};

/// Position of the ray in the cell; exactly on the face perpendicular to `axis`.
Triple position(const Triple& o, const Triple& d, const Triple& corner, double t, int axis, bool upper) {
  Triple x;
  for (std::size_t i = 0; i < 3; ++i) x[i] = std::clamp(o[i] + t * d[i] - corner[i], 0.0, 1.0);
  if (axis >= 0) x[static_cast<std::size_t>(axis)] = upper ? 1 : 0;
  return x;
}

}  // namespace

SdfGridView sdf_grid_view(const QuadricRow* quadrics, const SdfGridRow& grid, const ShapeRow& shape,
                          const float* values, const std::uint32_t* cells) {
  return {quadrics + shape.first_triangle, &grid, values + grid.first_value, cells + 2 * std::size_t{grid.first_cell}};
}

bool holds_surface(const SdfGridRow& grid, const float* values, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const Corners corners(grid, values, {x, y, z});
  const auto [smallest, largest] = std::minmax_element(std::begin(corners.v), std::end(corners.v));
  return *smallest <= 0 && *largest >= 0 && *smallest < *largest;
}

Bounds3f sdf_cell_bounds(const SdfGridView& view, std::uint32_t cell) {
  const Triple corner = to_double(corner_of(view, cell));
  constexpr double kMargin = 1.0 / 256;  // in cells
  float lower[3], upper[3];
  for (std::size_t i = 0; i < 3; ++i) {
    const float* m = view.placement->to_world + 4 * i;
    double low = m[3], high = m[3], size = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double a = double(m[axis]) * corner[axis], b = double(m[axis]) * (corner[axis] + 1);
      low += std::min(a, b);
      high += std::max(a, b);
      size += std::fabs(double(m[axis]));
    }
    const double slack = kMargin * size + 1e-6 * std::max(std::fabs(low), std::fabs(high));
    lower[i] = static_cast<float>(low - slack);
    upper[i] = static_cast<float>(high + slack);
  }
  return {{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

std::optional<QuadricHit> intersect_sdf_cell(const SdfGridView& view, std::uint32_t cell, Vec3f origin, Vec3f direction,
                                             float t_near, float t_far) noexcept {
  const QuadricRow& placement = *view.placement;
  const Triple o = apply(placement.to_object, origin, 1.0), d = apply(placement.to_object, direction, 0.0);
  const std::array<std::uint32_t, 3> low_corner = corner_of(view, cell);
  const Triple corner = to_double(low_corner);
  const Passage passage(o, d, corner, double(t_near), double(t_far));
  if (!(passage.begin < passage.end)) return std::nullopt;

  const Corners corners(*view.grid, view.values, low_corner);
  const auto goes_up = [&](int axis) { return axis >= 0 && d[static_cast<std::size_t>(axis)] > 0; };
  const Triple first = position(o, d, corner, passage.begin, passage.in, passage.in >= 0 && !goes_up(passage.in));
  const Triple last = position(o, d, corner, passage.end, passage.out, goes_up(passage.out));
  const double length = passage.end - passage.begin;
  const Cubic cubic(corners, first, d);

  double ends[4] = {0}, values[4] = {corners.at(first)};
  const int extrema = cubic.extrema(length, ends + 1);
  for (int i = 1; i <= extrema; ++i) values[i] = cubic.at(ends[i]);
  ends[extrema + 1] = length;
  values[extrema + 1] = corners.at(last);
  for (int i = 0; i <= extrema; ++i) {
    const double fa = values[i], fb = values[i + 1];
    if (!(fa * fb <= 0) || (fa == 0 && fb == 0)) continue;
    const double s = fa == 0 ? ends[i] : fb == 0 ? ends[i + 1] : cubic.root(ends[i], ends[i + 1], fa, fb);
    const float t = static_cast<float>(passage.begin + s);
    if (!(t > t_near && t < t_far)) continue;
    const Triple n = corners.gradient(position(o, d, corner, passage.begin + s, -1, false));
    const double scale = placement.normal_sign / std::max({std::fabs(n[0]), std::fabs(n[1]), std::fabs(n[2]), 1e-300});
    const Vec3f normal = placement.world_normal(
        {static_cast<float>(n[0] * scale), static_cast<float>(n[1] * scale), static_cast<float>(n[2] * scale)});
    return QuadricHit{t, normal};
  }
  return std::nullopt;
}

}  // namespace sheaf

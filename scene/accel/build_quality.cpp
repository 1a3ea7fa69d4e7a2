#include "scene/accel/build_quality.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Half the surface area of a box.
double half_surface(Vec3f lower, Vec3f upper) {
  const double x = double(upper.x) - lower.x, y = double(upper.y) - lower.y, z = double(upper.z) - lower.z;
  return x * y + y * z + z * x;
}

Vec3f lower_of(Vec3f a, Vec3f b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3f upper_of(Vec3f a, Vec3f b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

}  // namespace

double wasted_boxes(const AccelInput& in, ShapeRange shapes) {
  Vec3f lower{kInfinity, kInfinity, kInfinity}, upper{-kInfinity, -kInfinity, -kInfinity};
  double boxes = 0, triangles = 0;
  for (std::uint32_t i = shapes.first_shape; i < shapes.first_shape + shapes.shape_count; ++i) {
    const ShapeRow& shape = in.shapes[i];
    if (static_cast<ShapeKind>(shape.kind) != ShapeKind::kMesh) continue;
    for (std::uint32_t t = 0; t < shape.triangle_count; ++t) {
      const std::uint32_t* const index = in.triangles + 3 * (std::size_t(shape.first_triangle) + t);
      const auto vertex = [&](int k) { return in.vertices[std::size_t(shape.first_vertex) + index[k]].position; };
      const Vec3f a = vertex(0), b = vertex(1), c = vertex(2);
      const Vec3f from = lower_of(a, lower_of(b, c)), to = upper_of(a, upper_of(b, c));
      boxes += half_surface(from, to);
      // Both sides of the triangle, halved like the boxes.
      triangles += 0.5 * double(length(cross(b - a, c - a)));
      lower = lower_of(lower, from);
      upper = upper_of(upper, to);
    }
  }
  const double whole = boxes > 0 ? half_surface(lower, upper) : 0.0;
  return whole > 0 ? (boxes - triangles) / whole : 0.0;
}

bool is_worth_splitting(const AccelInput& in, ShapeRange shapes) {
  // Measured on two interiors: splits saved 10% of the time in Embree at a waste of 9.5, and nothing at 1.7.
  constexpr double kMinWaste = 4;
  return wasted_boxes(in, shapes) > kMinWaste;
}

}  // namespace sheaf

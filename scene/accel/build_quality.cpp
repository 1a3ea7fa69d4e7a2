#include "scene/accel/build_quality.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <functional>

namespace sheaf {

namespace {

/// Half the surface area of a box.
double half_surface(Vec3f lower, Vec3f upper) {
  const double x = double(upper.x) - lower.x, y = double(upper.y) - lower.y, z = double(upper.z) - lower.z;
  return x * y + y * z + z * x;
}

Vec3f lower_of(Vec3f a, Vec3f b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3f upper_of(Vec3f a, Vec3f b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

/// Sums over triangles.
struct BoxSums {
  Vec3f lower{kInfinity, kInfinity, kInfinity}, upper{-kInfinity, -kInfinity, -kInfinity};
  double boxes = 0, triangles = 0;  ///< half the surface areas

  void add(Vec3f a, Vec3f b, Vec3f c) {
    const Vec3f from = lower_of(a, lower_of(b, c)), to = upper_of(a, upper_of(b, c));
    boxes += half_surface(from, to);
    // Both sides of the triangle, halved like the boxes.
    triangles += 0.5 * double(length(cross(b - a, c - a)));
    lower = lower_of(lower, from);
    upper = upper_of(upper, to);
  }
  BoxSums operator+(const BoxSums& other) const {
    return {lower_of(lower, other.lower), upper_of(upper, other.upper), boxes + other.boxes,
            triangles + other.triangles};
  }
};

/// Sums of a mesh, the same for any number of threads.
BoxSums sums_of(const AccelInput& in, const ShapeRow& mesh) {
  constexpr std::uint32_t kGrain = 1 << 15;  // triangles
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::uint32_t>(0, mesh.triangle_count, kGrain), BoxSums(),
      [&](const tbb::blocked_range<std::uint32_t>& range, BoxSums sums) {
        for (std::uint32_t t = range.begin(); t < range.end(); ++t) {
          const std::uint32_t* const index = in.triangles + 3 * (std::size_t(mesh.first_triangle) + t);
          const auto vertex = [&](int k) { return in.vertices[std::size_t(mesh.first_vertex) + index[k]].position; };
          sums.add(vertex(0), vertex(1), vertex(2));
        }
        return sums;
      },
      std::plus<>());
}

bool is_mesh(const ShapeRow& shape) { return static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh; }

/// Number of triangles in the structure of these shapes.
double triangles_of(const AccelInput& in, ShapeRange shapes) {
  double count = 0;
  for (std::uint32_t i = shapes.first_shape; i < shapes.first_shape + shapes.shape_count; ++i)
    if (is_mesh(in.shapes[i])) count += in.shapes[i].triangle_count;
  return count;
}

/// Whether building a structure and tracing this number of rays in it takes less time along a Morton curve.
bool prefers_morton(double triangles, std::uint32_t shape_count, double rays) {
  // Measured processor time: a Morton curve saves 0.25 to 0.5 us per triangle, and rays take 15% to 40% longer. It pays
  // for fewer than 8 rays per triangle (coffee maker, height field) or 14 (interior), but loses 5% at any number in a
  // classroom with 1300 triangles per shape, whose structures overlap.
  constexpr double kFewRays = 2;         // per triangle
  constexpr double kLargeShapes = 4000;  // triangles per shape
  return !is_small_for_builds(triangles) && triangles >= kLargeShapes * shape_count && rays <= kFewRays * triangles;
}

/// Rays that each structure can expect: one element for the shapes outside of groups, then one for each group.
std::vector<double> shared_rays(const AccelInput& in, double rays) {
  std::vector<double> shared(1 + in.group_count, 0.0);
  shared[0] = rays;
  for (std::uint32_t i = 0; i < in.instance_count; ++i) shared[1 + in.instances[i].group] += rays / in.instance_count;
  return shared;
}

}  // namespace

double wasted_boxes(const AccelInput& in, ShapeRange shapes) {
  BoxSums sums;
  for (std::uint32_t i = shapes.first_shape; i < shapes.first_shape + shapes.shape_count; ++i)
    if (is_mesh(in.shapes[i])) sums = sums + sums_of(in, in.shapes[i]);
  const double whole = sums.boxes > 0 ? half_surface(sums.lower, sums.upper) : 0.0;
  return whole > 0 ? (sums.boxes - sums.triangles) / whole : 0.0;
}

bool is_small_for_builds(double triangles) {
  constexpr double kFewTriangles = 10'000;
  return triangles <= kFewTriangles;
}

BuildChoice choose_builds(const AccelInput& in, double rays) {
  // Measured on two interiors: splits saved 10% of the time in Embree at a waste of 9.5, and nothing at 1.7.
  constexpr double kMinWaste = 4;
  // Measured processor time: splits take another 0.2 to 2.1 us per triangle (classroom, coffee maker, noisy height
  // field), and rays of some 200 ns become at most 10% faster.
  constexpr double kMinRays = 30;  // per triangle
  const std::size_t count = 1 + std::size_t(in.group_count);
  const auto shapes_of = [&](std::size_t i) { return i == 0 ? ShapeRange{0, in.shape_count} : in.groups[i - 1]; };
  // Find the structures that are worth splitting
  std::vector<char> is_wasteful(count);
  tbb::parallel_for(std::size_t(0), count,
                    [&](std::size_t i) { is_wasteful[i] = wasted_boxes(in, shapes_of(i)) > kMinWaste ? 1 : 0; });
  double wasteful_triangles = 0;
  for (std::size_t i = 0; i < count; ++i)
    if (is_wasteful[i] != 0) wasteful_triangles += triangles_of(in, shapes_of(i));
  // Select those that the rays repay
  const bool repay_all = is_small_for_builds(wasteful_triangles) || rays >= kMinRays * wasteful_triangles;
  const std::vector<double> shared = shared_rays(in, rays);
  BuildChoice choice{std::vector<BvhBuild>(count, BvhBuild::kSurface)};
  for (std::size_t i = 0; i < count; ++i) {
    const double triangles = triangles_of(in, shapes_of(i));
    if (is_wasteful[i] != 0) {
      if (repay_all || shared[i] >= kMinRays * triangles) choice.builds[i] = BvhBuild::kSpatial;
      if (choice.builds[i] != BvhBuild::kSpatial)
        choice.splits = BvhSplits::kLeftOut;
      else if (choice.splits == BvhSplits::kNotNeeded)
        choice.splits = BvhSplits::kBuilt;
    }
    if (choice.builds[i] != BvhBuild::kSpatial && prefers_morton(triangles, shapes_of(i).shape_count, shared[i]))
      choice.builds[i] = BvhBuild::kMorton;
  }
  return choice;
}

}  // namespace sheaf

#include "scene/light_bounds.h"

#include "scene/light_cone.h"
#include "scene/quadric.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Like the weights by which lights are chosen without a tree: positive and finite however large the light.
float emitted_power(double peak_intensity) {
  return static_cast<float>(std::clamp(double(kPi) * peak_intensity, 1e-30, 1e30));
}

Vec3f to_float3(const Vec3d& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

Vec3d cross3(const float* a, const float* b) {
  Vec3d out;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
    out[c] = double(a[d]) * b[e] - double(a[e]) * b[d];
  }
  return out;
}

/// The directions in which peaks are looked for: the axes, the diagonals of a cube, and one of the caller's.
class PeakSearch {
 public:
  explicit PeakSearch(const Vec3d& favourite) {
    directions_[0] = favourite;
    std::size_t n = 1;
    for (int sign = -1; sign <= 1; sign += 2)
      for (std::size_t axis = 0; axis < 3; ++axis, ++n) directions_[n] = Vec3d{}, directions_[n][axis] = sign;
    const double diagonal = 1.0 / std::sqrt(3.0);
    for (int corner = 0; corner < 8; ++corner, ++n)
      for (std::size_t c = 0; c < 3; ++c) directions_[n][c] = (corner >> c & 1) != 0 ? diagonal : -diagonal;
  }
  /// A surface of that area vector (its normal times its area), seen from its front only.
  void add(const Vec3d& area_vector) {
    for (std::size_t i = 0; i < kDirections; ++i) {
      const Vec3d& d = directions_[i];
      areas_[i] += std::max(0.0, d[0] * area_vector[0] + d[1] * area_vector[1] + d[2] * area_vector[2]);
    }
  }
  /// The largest projected area found.
  double projected_area() const { return *std::max_element(areas_.begin(), areas_.end()); }

 private:
  static constexpr std::size_t kDirections = 15;
  std::array<Vec3d, kDirections> directions_{};
  std::array<double, kDirections> areas_{};
};

/// A light with a frame, as a spot that is as bright everywhere.
LightBounds cone_light_bounds(const LightRow& row, const LightFrameRow& frame, Vec3f position, double power) {
  double cos_total = frame.words[0];  // kSmoothSpot
  if (static_cast<LightKind>(row.kind) == LightKind::kSpot) cos_total = std::cos(double(frame.words[0]));
  if (static_cast<LightKind>(row.kind) == LightKind::kProjector) {
    const double tangent = 0.5 * std::hypot(1.0 / frame.words[0], 1.0 / frame.words[1]);  // of a corner
    cos_total = 1.0 / std::sqrt(1.0 + tangent * tangent);
  }
  const float* m = frame.to_light;
  const Vec3f rows[3] = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}};
  const float size = dot(rows[2], rows[2]);
  float distortion = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j)
      distortion = std::max(distortion, std::fabs(dot(rows[i], rows[j]) - (i == j ? size : 0)));
  if (distortion > 1e-4f * size) cos_total = -1.0;  // a cone that is stretched may reach anywhere
  const Vec3f axis = normalize(rows[2]);
  const double solid_angle = 2.0 * double(kPi) * std::max(1.0 - cos_total, 1e-6);
  return spot_light_bounds(position, axis, static_cast<float>(cos_total), static_cast<float>(power / solid_angle));
}

}  // namespace

LightBounds mesh_light_bounds(std::span<const LightTriangleRow> triangles, float radiance) {
  LightBounds out;
  DirectionCone cone;
  bool empty = true;
  std::vector<Vec3d> area_vectors;
  Vec3d lower{}, upper{};
  for (const LightTriangleRow& t : triangles) {
    Vec3d area_vector = cross3(t.edge1, t.edge2);
    const double twice = std::hypot(area_vector[0], area_vector[1], area_vector[2]);
    if (!(twice > 0.0) || !std::isfinite(twice)) continue;
    // Mirrored instances shine against their winding.
    const double along = area_vector[0] * t.normal[0] + area_vector[1] * t.normal[1] + area_vector[2] * t.normal[2];
    if (along < 0.0)
      for (double& component : area_vector) component = -component;
    Vec3d normal;
    for (std::size_t c = 0; c < 3; ++c) {
      normal[c] = area_vector[c] / twice;
      area_vector[c] *= 0.5;
      const double p = t.p[c], q = p + t.edge1[c], r = p + t.edge2[c];
      // Vertices are sums of rounded numbers here and in the kernels.
      const double slack = 1e-6 * (std::fabs(p) + std::fabs(double(t.edge1[c])) + std::fabs(double(t.edge2[c])));
      const double low = std::min({p, q, r}) - slack, high = std::max({p, q, r}) + slack;
      lower[c] = empty ? low : std::min(lower[c], low);
      upper[c] = empty ? high : std::max(upper[c], high);
    }
    const DirectionCone single(normal, 0.0);
    cone = empty ? single : join(cone, single);
    empty = false;
    area_vectors.push_back(area_vector);
  }
  PeakSearch peak(cone.axis);
  for (const Vec3d& a : area_vectors) peak.add(a);
  out.lower = to_float3(lower);
  out.upper = to_float3(upper);
  out.axis = to_float3(cone.axis);
  out.cos_theta_o = static_cast<float>(cone.cos_theta);
  out.power = emitted_power(double(radiance) * peak.projected_area());
  return out;
}

LightBounds quadric_light_bounds(const QuadricRow& row, float radiance) {
  const QuadricBounds box = quadric_bounds(row);
  LightBounds out;
  out.lower = box.lower;
  out.upper = box.upper;
  const double area = quadric_area(row);
  if (row.kind == ShapeKind::kDisk) {
    // The inverse transpose turns (0, 0, 1) into the third row of the inverse.
    const double n[3] = {row.to_object[8], row.to_object[9], row.to_object[10]};
    const double scale = row.normal_sign / std::hypot(n[0], n[1], n[2]);
    out.axis = to_float3({n[0] * scale, n[1] * scale, n[2] * scale});
    out.cos_theta_o = 1;
    out.power = emitted_power(radiance * area);
    return out;
  }
  // From the side, a sphere shows a quarter of its area and a cylinder 1 / pi.
  out.power = emitted_power(radiance * area * (row.kind == ShapeKind::kSphere ? 0.25 : double(kInvPi)));
  return out;
}

LightBounds point_light_bounds(Vec3f position, float intensity) {
  LightBounds out;
  out.lower = out.upper = position;
  out.power = emitted_power(intensity);
  return out;
}

LightBounds spot_light_bounds(Vec3f position, Vec3f axis, float cos_total, float intensity) {
  LightBounds out = point_light_bounds(position, intensity);
  out.axis = axis;
  // The light does not fade with the angle from a normal: the cone of "normals" is the cone of light.
  out.cos_theta_o = cos_total;
  out.cos_theta_e = 1;
  return out;
}

LightBounds bounds_of_light(const SceneView& scene, std::uint32_t light, double power) {
  const LightRow& row = scene.lights[light];
  const Vec3f position{row.position[0], row.position[1], row.position[2]};
  switch (static_cast<LightKind>(row.kind)) {
    case LightKind::kMesh:
      return mesh_light_bounds({scene.light_triangles + row.first_triangle, row.triangle_count},
                               static_cast<float>(power / (double(kPi) * row.area)));
    case LightKind::kSphere:
    case LightKind::kQuadric: {
      const QuadricRow& quadric = scene.quadrics[row.first_triangle];
      return quadric_light_bounds(quadric, static_cast<float>(power / (double(kPi) * quadric_area(quadric))));
    }
    case LightKind::kSpot:
    case LightKind::kSmoothSpot:
    case LightKind::kProjector:
      return cone_light_bounds(row, scene.light_frames[row.detail], position, power);
    case LightKind::kVolume: {
      LightBounds out = point_light_bounds(position, static_cast<float>(power * (0.25 * double(kInvPi))));
      out.upper = position + Vec3f{row.area, row.radius, row.depth};
      return out;
    }
    default:
      return point_light_bounds(position, static_cast<float>(power * (0.25 * double(kInvPi))));
  }
}

}  // namespace sheaf

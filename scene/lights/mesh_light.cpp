#include "scene/lights/mesh_light.h"

#include "core/math/direction_cone.h"
#include "core/math/frame.h"
#include "core/sampling/alias_table.h"
#include "core/sampling/warp.h"
#include "scene/lights/area_light.h"
#include "scene/lights/light_bounds.h"
#include "scene/lights/texture_mean.h"
#include "scene/surfaces/shape.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

struct TriangleWithArea {
  LightTriangleRow row{};
  double area = 0;
};

/// The triangle with the given corners in world space; `side` = -1 flips its normal.
TriangleWithArea make_triangle(const double (&p)[3][3], double side) {
  // Compute normal and area
  double normal[3], squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
    normal[c] = side * ((p[1][d] - p[0][d]) * (p[2][e] - p[0][e]) - (p[1][e] - p[0][e]) * (p[2][d] - p[0][d]));
    squared += normal[c] * normal[c];
  }
  const double twice_area = std::sqrt(squared);
  TriangleWithArea out;
  out.area = 0.5 * twice_area;
  // Store the rounded triangle
  float* const first[3] = {&out.row.p.x, &out.row.p.y, &out.row.p.z};
  float* const edge1[3] = {&out.row.edge1.x, &out.row.edge1.y, &out.row.edge1.z};
  float* const edge2[3] = {&out.row.edge2.x, &out.row.edge2.y, &out.row.edge2.z};
  float* const unit[3] = {&out.row.normal.x, &out.row.normal.y, &out.row.normal.z};
  double across = 0, extent = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double largest = std::max({std::fabs(p[0][c]), std::fabs(p[1][c]), std::fabs(p[2][c])});
    *first[c] = static_cast<float>(p[0][c]);
    *edge1[c] = static_cast<float>(p[1][c] - p[0][c]);
    *edge2[c] = static_cast<float>(p[2][c] - p[0][c]);
    *unit[c] = twice_area > 0.0 ? static_cast<float>(normal[c] / twice_area) : 0.0f;
    across += std::fabs(*unit[c]) * largest;
    extent = std::max(extent, largest);
  }
  // Bound the rounding error of points on it
  out.row.offset = static_cast<float>(kOffsetUlps * (across + extent));
  return out;
}

/// The corners of a triangle of a shape, in the space of its vertices. `first_vertex`: of a step.
void corners_of(const ShapeTables& tables, const ShapeRow& shape, std::size_t first_vertex, std::uint32_t triangle,
                const VertexRow* (&corners)[3]) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t vertex = tables.triangles[3 * (std::size_t(shape.first_triangle) + triangle) + k];
    corners[k] = &tables.vertices[first_vertex + vertex];
  }
}

TriangleWithArea make_triangle(const VertexRow* const (&corners)[3], const LightInstance* instance) {
  double p[3][3], q[3][3];
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3f at = corners[k]->position;
    p[k][0] = at.x, p[k][1] = at.y, p[k][2] = at.z;
  }
  if (instance == nullptr) return make_triangle(p, 1.0);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      const float* m = instance->rest.to_world + 4 * c;
      q[k][c] = m[0] * p[k][0] + m[1] * p[k][1] + m[2] * p[k][2] + m[3];
    }
  TriangleWithArea out = make_triangle(q, instance->rest.determinant < 0.0f ? -1.0 : 1.0);
  const LightTriangleRow own = make_triangle(p, 1.0).row;
  for (const VertexRow* corner : corners)
    out.row.offset = std::max(out.row.offset, instance->offset(corner->position, own.normal, own.offset));
  return out;
}

LightUvRow make_uvs(const ShapeRow& shape, const VertexRow* const (&corners)[3]) {
  if ((shape.flags & kHasUvs) == 0) return {{0, 0}, {1, 0}, {0, 1}, {}};
  return {corners[0]->uv, corners[1]->uv, corners[2]->uv, {}};
}

/// The steps of a shape's mesh; no segments: it does not deform.
DeformationRow motion_of(const DeformationRow* motions, const ShapeRow& shape) {
  const std::uint32_t row = shape.flags >> kDeformationShift;
  return row == 0 ? DeformationRow{} : motions[row - 1];
}

/// Triangles at the steps of a mesh, and for each pair of successive steps triangles whose normals complete the cone of
/// the normals in between. The area vector of a triangle with linearly moving edges is a quadratic Bezier curve; its
/// middle control point is half the sum of the cross products of either first edge with the other second edge.
std::vector<LightTriangleRow> with_normal_cones(std::span<const LightTriangleRow> steps, std::size_t count) {
  std::vector<LightTriangleRow> out(steps.begin(), steps.end());
  for (std::size_t i = 0; i + count < steps.size(); ++i) {
    const LightTriangleRow &a = steps[i], &b = steps[i + count];
    const Vec3f middle = (cross(a.edge1, b.edge2) + cross(b.edge1, a.edge2)) * 0.5f;
    const float size = length(middle);
    if (!(size > 0.0f)) continue;
    const Frame<Scalar> frame = Frame<Scalar>::from_normal(middle / size);
    const float edge = std::sqrt(size);
    LightTriangleRow row = a;
    row.edge1 = frame.s * edge;
    row.edge2 = frame.t * edge;
    row.normal = frame.n * (dot(cross(a.edge1, a.edge2), a.normal) < 0.0f ? -1.0f : 1.0f);
    out.push_back(row);
  }
  return out;
}

Triple to_double3(Vec3f v) { return {v.x, v.y, v.z}; }
Vec3f to_float3(const Triple& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

Triple cross3(const Triple& a, const Triple& b) {
  Triple out;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
    out[c] = a[d] * b[e] - a[e] * b[d];
  }
  return out;
}

/// Finds the maximum projected area over a set of directions: the axes, the diagonals of a cube, and one given
/// direction.
class PeakSearch {
 public:
  explicit PeakSearch(const Triple& favorite) {
    directions_[0] = favorite;
    std::size_t n = 1;
    for (int sign = -1; sign <= 1; sign += 2)
      for (std::size_t axis = 0; axis < 3; ++axis, ++n) directions_[n] = Triple{}, directions_[n][axis] = sign;
    const double diagonal = 1.0 / std::sqrt(3.0);
    for (int corner = 0; corner < 8; ++corner, ++n)
      for (std::size_t c = 0; c < 3; ++c) directions_[n][c] = (corner >> c & 1) != 0 ? diagonal : -diagonal;
  }
  /// Adds a one-sided surface with the given area vector (its normal times its area).
  void add(const Triple& area_vector) {
    for (std::size_t i = 0; i < kDirections; ++i) {
      const Triple& d = directions_[i];
      areas_[i] += std::max(0.0, d[0] * area_vector[0] + d[1] * area_vector[1] + d[2] * area_vector[2]);
    }
  }
  /// The maximum projected area found.
  double projected_area() const { return *std::max_element(areas_.begin(), areas_.end()); }

 private:
  static constexpr std::size_t kDirections = 15;
  std::array<Triple, kDirections> directions_{};
  std::array<double, kDirections> areas_{};
};

}  // namespace

Vec3f MeshLightKind::power(const SceneView&, const LightRow& light) {
  return emitted_rgb(light) * (exitance_factor(light) * light.data<MeshLightData>().area);
}

LightBounds MeshLightKind::bounds(const SceneView& scene, const LightRow& light, double power) {
  const auto mesh = light.data<MeshLightData>();
  const double area = double{sides_of(light)} * mesh.area;
  const std::uint32_t segments = motion_of(scene.motion.deformations, scene.geometry.shapes[mesh.shape]).segment_count;
  const std::span<const LightTriangleRow> first(scene.lights.triangles + mesh.first_triangle,
                                                (segments + std::size_t(1)) * mesh.triangle_count);
  const auto radiance = static_cast<float>(power / (double(kPi) * area));
  LightBounds out = segments == 0 ? mesh_light_bounds(first, radiance)
                                  : mesh_light_bounds(with_normal_cones(first, mesh.triangle_count),
                                                      radiance / static_cast<float>(2 * segments + 1));
  out.two_sided = light.is_two_sided();
  // Cones beyond a hemisphere are not convex, and need not contain the normals in between
  if (segments > 0 && out.cos_theta_o < 0.0f) out.cos_theta_o = -1.0f;
  return out;
}

/// Mean of the texture.
Vec3f MeshLightKind::integral(const SceneView& scene, const LightRow& light, int mean_points) {
  const auto mesh = light.data<MeshLightData>();
  TextureMean mean(scene, light.texture);
  int next = 0;
  for (std::uint32_t i = 0; i < mesh.triangle_count; ++i) {
    const double fraction = scene.lights.triangle_alias[mesh.first_triangle + i].pdf;
    const int points = std::clamp(static_cast<int>(std::ceil(fraction * mean_points)), 1, mean_points);
    const LightUvRow& uvs = scene.lights.uvs[mesh.first_uv + i];
    for (int k = 0; k < points; ++k) {
      const Vec2f u = spread_point(next++);
      const Vec2f b = square_to_triangle<Scalar>(u.x, u.y);
      mean.add({uvs.at(1 - b.x - b.y, b.x, b.y), mesh.shape, i, b.x, b.y}, fraction / points);
    }
  }
  return mean.value();
}

/// The uv of the triangles and their fractions of the area. Large meshes do not share: comparing them takes longer.
IntegralSharing MeshLightKind::integral_key(const SceneView& scene, const LightRow& light,
                                            std::vector<std::uint32_t>& key) {
  constexpr std::uint32_t kMaxTriangles = 64;
  if (light.texture == kNone) return IntegralSharing::kNoIntegral;
  const auto mesh = light.data<MeshLightData>();
  if (mesh.triangle_count > kMaxTriangles) return IntegralSharing::kOwn;
  for (std::uint32_t i = 0; i < mesh.triangle_count; ++i) {
    const LightUvRow& uvs = scene.lights.uvs[mesh.first_uv + i];
    for (const Vec2f uv : {uvs.at(1, 0, 0), uvs.at(0, 1, 0), uvs.at(0, 0, 1)})
      key.insert(key.end(), {float_bits(uv.x), float_bits(uv.y)});
    key.push_back(rounded_fraction(scene.lights.triangle_alias[mesh.first_triangle + i].pdf));
  }
  return IntegralSharing::kShared;
}

void complete_mesh_light(AreaLight& light, const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                         const LightTableOffsets& offsets, const LightInstance* instance) {
  const bool textured = light.row.needs_texture_query();
  const DeformationRow motion = motion_of(tables.deformations, shape);
  std::vector<float> areas(shape.triangle_count);
  double area = 0;
  for (std::uint32_t step = 0; step <= motion.segment_count; ++step)
    for (std::uint32_t i = 0; i < shape.triangle_count; ++i) {
      const VertexRow* corners[3];
      corners_of(tables, shape, shape.first_vertex + std::size_t(step) * motion.vertex_count, i, corners);
      const TriangleWithArea triangle = make_triangle(corners, instance);
      light.triangles.push_back(triangle.row);
      if (textured && step == 0) light.uvs.push_back(make_uvs(shape, corners));
      const auto fraction = static_cast<float>(triangle.area / (motion.segment_count + 1));
      areas[i] += fraction;
      area += fraction;
    }
  const std::vector<AliasEntry> alias = build_alias_table(areas);
  for (std::uint32_t step = 0; step <= motion.segment_count; ++step)
    light.alias.insert(light.alias.end(), alias.begin(), alias.end());
  light.area = static_cast<float>(area);
  light.row.kind = static_cast<std::uint32_t>(kLightKind<MeshLightKind>);
  light.row.set_data(MeshLightData<Scalar>{shape_index, offsets.first_triangle, shape.triangle_count,
                                           textured ? offsets.first_uv : 0u, light.area});
  if (motion.segment_count == 0) complete_rectangle_light(light);
}

LightBounds mesh_light_bounds(std::span<const LightTriangleRow> triangles, float radiance) {
  LightBounds out;
  DirectionCone cone;
  bool empty = true;
  std::vector<Triple> area_vectors;
  Triple lower{}, upper{};
  for (const LightTriangleRow& t : triangles) {
    const Triple edge1 = to_double3(t.edge1), edge2 = to_double3(t.edge2);
    const Triple first = to_double3(t.p), facing = to_double3(t.normal);
    Triple area_vector = cross3(edge1, edge2);
    const double twice = std::hypot(area_vector[0], area_vector[1], area_vector[2]);
    if (!(twice > 0.0) || !std::isfinite(twice)) continue;
    // Mirrored instances emit on the side opposite to their winding.
    const double along = area_vector[0] * facing[0] + area_vector[1] * facing[1] + area_vector[2] * facing[2];
    if (along < 0.0)
      for (double& component : area_vector) component = -component;
    Triple normal;
    for (std::size_t c = 0; c < 3; ++c) {
      normal[c] = area_vector[c] / twice;
      area_vector[c] *= 0.5;
      const double p = first[c], q = p + edge1[c], r = p + edge2[c];
      // Vertices are sums of rounded numbers, here and in kernels.
      const double slack = 1e-6 * (std::fabs(p) + std::fabs(edge1[c]) + std::fabs(edge2[c]));
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
  for (const Triple& a : area_vectors) peak.add(a);
  out.lower = to_float3(lower);
  out.upper = to_float3(upper);
  out.axis = to_float3(cone.axis);
  out.cos_theta_o = static_cast<float>(cone.cos_theta);
  out.power = peak_power(double(radiance) * peak.projected_area());
  return out;
}

}  // namespace sheaf

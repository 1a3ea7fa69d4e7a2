#include "scene/light.h"

#include "scene/compile_materials.h"
#include "scene/quadric.h"
#include "scene/shape.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

struct TriangleWithArea {
  LightTriangleRow row{};
  double area = 0;
};

/// The offset of a point of an instance; see place_instance().
float instance_offset(const InstanceRow& instance, Vec3f p, Vec3f ng, float offset) {
  SurfacePoint<Scalar> y{};
  y.p = p;
  y.ng = y.ns = ng;
  y.offset = offset;
  place_instance<Scalar, false>(load_instances<Scalar>(&instance, 0), true, y);
  return y.offset;
}

/// The triangle with corners `p`, in world space; `side` is -1 to turn its normal.
TriangleWithArea make_triangle(const double (&p)[3][3], double side) {
  double normal[3], squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3, e = (c + 2) % 3;
    normal[c] = side * ((p[1][d] - p[0][d]) * (p[2][e] - p[0][e]) - (p[1][e] - p[0][e]) * (p[2][d] - p[0][d]));
    squared += normal[c] * normal[c];
  }
  const double twice_area = std::sqrt(squared);
  TriangleWithArea out;
  out.area = 0.5 * twice_area;
  double across = 0, extent = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double largest = std::max({std::fabs(p[0][c]), std::fabs(p[1][c]), std::fabs(p[2][c])});
    out.row.p[c] = static_cast<float>(p[0][c]);
    out.row.edge1[c] = static_cast<float>(p[1][c] - p[0][c]);
    out.row.edge2[c] = static_cast<float>(p[2][c] - p[0][c]);
    out.row.normal[c] = twice_area > 0.0 ? static_cast<float>(normal[c] / twice_area) : 0.0f;
    across += std::fabs(out.row.normal[c]) * largest;
    extent = std::max(extent, largest);
  }
  out.row.offset = static_cast<float>(kOffsetUlps * (across + extent));
  return out;
}

/// The corners of a triangle of a shape, in the space of its vertices.
void corners_of(const ShapeTables& tables, const ShapeRow& shape, std::uint32_t triangle,
                const VertexRow* (&corners)[3]) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t vertex = tables.triangles[3 * (std::size_t(shape.first_triangle) + triangle) + k];
    corners[k] = &tables.vertices[std::size_t(shape.first_vertex) + vertex];
  }
}

TriangleWithArea make_triangle(const VertexRow* const (&corners)[3], const InstanceRow* instance) {
  double p[3][3], q[3][3];
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t c = 0; c < 3; ++c) p[k][c] = corners[k]->position[c];
  if (instance == nullptr) return make_triangle(p, 1.0);
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      const float* m = instance->to_world + 4 * c;
      q[k][c] = m[0] * p[k][0] + m[1] * p[k][1] + m[2] * p[k][2] + m[3];
    }
  TriangleWithArea out = make_triangle(q, instance->determinant < 0.0f ? -1.0 : 1.0);
  const LightTriangleRow own = make_triangle(p, 1.0).row;
  for (const VertexRow* corner : corners)
    out.row.offset = std::max(
        out.row.offset, instance_offset(*instance, {corner->position[0], corner->position[1], corner->position[2]},
                                        {own.normal[0], own.normal[1], own.normal[2]}, own.offset));
  return out;
}

LightUvRow make_uvs(const ShapeRow& shape, const VertexRow* const (&corners)[3]) {
  if ((shape.flags & kHasUvs) == 0) return {{0, 0, 1, 0, 0, 1}, {}};
  LightUvRow row{};
  for (std::size_t k = 0; k < 3; ++k) std::copy_n(corners[k]->uv, 2, row.uv + 2 * k);
  return row;
}

void make_mesh_light(AreaLight& light, const ShapeRow& shape, const ShapeTables& tables, const LightPlaces& places,
                     const InstanceRow* instance) {
  light.row.kind = static_cast<std::uint32_t>(LightKind::kMesh);
  light.row.first_triangle = places.first_triangle;
  light.row.triangle_count = shape.triangle_count;
  const bool textured = light.row.texture != kNone;
  if (textured) light.row.detail = places.first_uv;
  std::vector<float> areas;
  double area = 0;
  for (std::uint32_t i = 0; i < shape.triangle_count; ++i) {
    const VertexRow* corners[3];
    corners_of(tables, shape, i, corners);
    const TriangleWithArea triangle = make_triangle(corners, instance);
    light.triangles.push_back(triangle.row);
    if (textured) light.uvs.push_back(make_uvs(shape, corners));
    areas.push_back(static_cast<float>(triangle.area));
    area += areas.back();
  }
  light.alias = build_alias_table(areas);
  light.row.area = static_cast<float>(area);
}

/// The largest offset at points of a quadric of an instance.
float quadric_offset(const QuadricRow& own, const InstanceRow& instance) {
  SceneView view;
  view.quadrics = &own;
  const QuadricLanes<Scalar> q = load_quadrics<Scalar>(view, 0);
  float largest = 0;
  constexpr int kPoints = 64;
  for (int i = 0; i < kPoints; ++i) {
    const float u = (static_cast<float>(i % 8) + 0.5f) / 8, v = (static_cast<float>(i / 8) + 0.5f) / 8;
    Vec3f x = square_to_sphere<Scalar>(u, v);
    if (own.kind == ShapeKind::kCylinder) x = {std::cos(2 * kPi * v), std::sin(2 * kPi * v), u};
    if (own.kind == ShapeKind::kDisk) x = {std::cos(2 * kPi * v), std::sin(2 * kPi * v), 0};
    const auto y = quadric_surface<Scalar, false>(q, static_cast<std::uint32_t>(own.kind), x);
    largest = std::max(largest, instance_offset(instance, y.p, y.ng, y.offset));
  }
  return 1.5f * largest;
}

/// A quadric of an instance, in world space.
QuadricRow place_quadric(const QuadricRow& own, const InstanceRow& instance) {
  Matrix4 inner, outer;
  for (std::size_t i = 0; i < 12; ++i) {
    inner.m[i / 4][i % 4] = own.to_world[i];
    outer.m[i / 4][i % 4] = instance.to_world[i];
  }
  return make_quadric(own.kind, Transform(outer * inner), own.normal_sign < 0.0f);
}

void make_quadric_light(AreaLight& light, const ShapeRow& shape, const ShapeTables& tables, const LightPlaces& places,
                        const InstanceRow* instance) {
  QuadricRow q = tables.quadrics[shape.first_triangle];
  LightRow& row = light.row;
  row.first_triangle = places.quadric;
  if (instance != nullptr) {
    row.detail = float_bits(quadric_offset(q, *instance));
    q = place_quadric(q, *instance);
    light.quadric = q;
  }
  // Light leaves a flipped sphere inwards, where the cone of directions that see it says nothing.
  const bool cone = q.kind == ShapeKind::kSphere && q.uniform_scale > 0.0f && q.normal_sign > 0.0f;
  row.kind = static_cast<std::uint32_t>(cone ? LightKind::kSphere : LightKind::kQuadric);
  row.area = canonical_area(q.kind);
  row.radius = q.uniform_scale;
  for (std::size_t c = 0; c < 3; ++c) row.position[c] = q.to_world[4 * c + 3];
}

void set_radiance(LightRow& row, Vec3f value) {
  row.radiance[0] = value.x;
  row.radiance[1] = value.y;
  row.radiance[2] = value.z;
}

void set_position(LightRow& row, Vec3f p) {
  row.position[0] = p.x;
  row.position[1] = p.y;
  row.position[2] = p.z;
}

LightRow light_row(LightKind kind, Vec3f radiance, Vec3f position) {
  LightRow row;
  row.kind = static_cast<std::uint32_t>(kind);
  set_radiance(row, radiance);
  set_position(row, position);
  return row;
}

/// The rotation of a transform that scales all lengths alike, world to local, row by row.
std::array<double, 9> rotation_of(const Transform& to_world, const char* what, const SourceLocation& where) {
  const auto& m = to_world.matrix().m;
  double squared[3], mixed = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    squared[j] = m[0][j] * m[0][j] + m[1][j] * m[1][j] + m[2][j] * m[2][j];
    const std::size_t k = (j + 1) % 3;
    mixed = std::max(mixed, std::fabs(m[0][j] * m[0][k] + m[1][j] * m[1][k] + m[2][j] * m[2][k]));
  }
  const auto [least, most] = std::minmax_element(squared, squared + 3);
  constexpr double kTolerance = 1e-4;
  if (!(*least > 0.0) || *most - *least > kTolerance * *most || mixed > kTolerance * *most)
    throw SceneError(where, std::string(what) + " is stretched by its transform, expected a rotation");
  std::array<double, 9> rows;
  for (std::size_t i = 0; i < 9; ++i) rows[i] = m[i % 3][i / 3] / std::sqrt(squared[i / 3]);
  return rows;
}

LightFrameRow frame_row(const Transform& to_world) {
  const auto& inverse = to_world.inverse_matrix().m;
  LightFrameRow row{};
  for (std::size_t i = 0; i < 12; ++i)
    row.to_light[i] = static_cast<float>(inverse[i / 4][i % 4] / inverse[3][3]);
  return row;
}

}  // namespace

AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                          const AreaEmission& emission, const LightPlaces& places, const InstanceRow* instance) {
  AreaLight light;
  light.row.shape = shape_index;
  light.row.texture = emission.texture;
  set_radiance(light.row, emission.radiance);
  if (static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh) {
    make_mesh_light(light, shape, tables, places, instance);
  } else {
    make_quadric_light(light, shape, tables, places, instance);
  }
  return light;
}

PlacedLight make_point_light(Vec3f intensity, Vec3f position) {
  return {light_row(LightKind::kPoint, intensity, position), std::nullopt};
}

PlacedLight make_constant_light(Vec3f radiance) {
  return {light_row(LightKind::kConstant, radiance, {0, 0, 0}), std::nullopt};
}

PlacedLight make_spot_light(const SpotLightDescription& spot, const SourceLocation& where) {
  const double cutoff = spot.cutoff_angle * kDegree, beam = spot.beam_width * kDegree;
  if (!(spot.cutoff_angle > 0.0f && spot.cutoff_angle <= 180.0f))
    throw SceneError(where, "the cone of a spot light must lie between 0 and 180 degrees, found " +
                                std::to_string(spot.cutoff_angle));
  if (!(spot.beam_width >= 0.0f && spot.beam_width <= spot.cutoff_angle))
    throw SceneError(where, "the beam of a spot light, found " + std::to_string(spot.beam_width) +
                                " degrees, must not be wider than its cone of " + std::to_string(spot.cutoff_angle));
  if (spot.texture && !(spot.cutoff_angle < 90.0f))
    throw SceneError(where, "the cone of a spot light with a texture must be below 90 degrees, found " +
                                std::to_string(spot.cutoff_angle));
  const bool smooth = spot.falloff == SpotLightDescription::Falloff::kSmooth;
  PlacedLight light{light_row(smooth ? LightKind::kSmoothSpot : LightKind::kSpot, emission_rgb(spot.intensity),
                              spot.to_world.point({0, 0, 0})),
                    frame_row(spot.to_world)};
  if (spot.texture) light.row.texture = static_cast<std::uint32_t>(*spot.texture);
  // A step of no width is one of very little.
  constexpr double kLeastWidth = 1e-7;
  const double outer = smooth ? std::cos(cutoff) : cutoff;
  const double width = smooth ? std::cos(beam) - std::cos(cutoff) : cutoff - beam;
  light.frame->words[0] = static_cast<float>(outer);
  light.frame->words[1] = static_cast<float>(1.0 / std::max(width, kLeastWidth));
  light.frame->words[2] = static_cast<float>(1.0 / std::tan(std::min(cutoff, 89.999 * kDegree)));
  return light;
}

PlacedLight make_directional_light(const DirectionalLightDescription& light, const SourceLocation& where) {
  const float length = sheaf::length(light.direction);
  if (!(length > 0.0f) || !std::isfinite(length)) throw SceneError(where, "the direction of the light has no length");
  return {light_row(LightKind::kDirectional, emission_rgb(light.irradiance), light.direction * (-1.0f / length)),
          std::nullopt};
}

PlacedLight make_projector(const ProjectorDescription& projector, double aspect, const SourceLocation& where) {
  const std::array<double, 9> rotation = rotation_of(projector.to_world, "a projector", where);
  const auto* constant = std::get_if<SpectrumDescription>(&projector.irradiance);
  const Vec3f color = constant != nullptr ? emission_rgb(*constant) : Vec3f{1, 1, 1};
  const Vec3f origin = projector.to_world.point({0, 0, 0});
  PlacedLight light{light_row(LightKind::kProjector, color * (kPi * projector.scale), origin), LightFrameRow{}};
  if (constant == nullptr) light.row.texture = static_cast<std::uint32_t>(std::get<TextureId>(projector.irradiance));
  const double half_width = half_width_of(projector.fov, projector.fov_axis, aspect, 1.0, where);
  float* m = light.frame->to_light;
  for (std::size_t i = 0; i < 3; ++i) {
    const double* row = rotation.data() + 3 * i;
    for (std::size_t j = 0; j < 3; ++j) m[4 * i + j] = static_cast<float>(row[j]);
    m[4 * i + 3] = static_cast<float>(-(row[0] * origin.x + row[1] * origin.y + row[2] * origin.z));
  }
  light.frame->words[0] = static_cast<float>(0.5 / half_width);
  light.frame->words[1] = static_cast<float>(0.5 * aspect / half_width);
  return light;
}

PlacedLight make_envmap_light(const Envmap& map) {
  return {light_row(LightKind::kEnvmap, map.mean, {0, 0, 0}), std::nullopt};
}

void set_rotation(Envmap& map, const Transform& to_world, const SourceLocation& where) {
  const std::array<double, 9> rotation = rotation_of(to_world, "an environment map", where);
  std::transform(rotation.begin(), rotation.end(), map.to_map, [](double v) { return static_cast<float>(v); });
}

}  // namespace sheaf

#include "scene/lights/quadric_light.h"

#include "core/sampling/warp.h"
#include "scene/accel/quadric.h"
#include "scene/lights/area_light.h"
#include "scene/lights/light_bounds.h"
#include "scene/lights/texture_mean.h"
#include "scene/surfaces/shape.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Upper estimate of the ray offset on an instance's quadric, from sample points.
float quadric_offset(const QuadricRow& own, const LightInstance& instance) {
  float largest = 0;
  constexpr int kPoints = 64;
  for (int i = 0; i < kPoints; ++i) {
    const int column = i % 8, row = i / 8;
    const float u = (static_cast<float>(column) + 0.5f) / 8, v = (static_cast<float>(row) + 0.5f) / 8;
    Vec3f x = square_to_sphere<Scalar>(u, v);
    if (own.kind == ShapeKind::kCylinder) x = {std::cos(2 * kPi * v), std::sin(2 * kPi * v), u};
    if (own.kind == ShapeKind::kDisk) x = {std::cos(2 * kPi * v), std::sin(2 * kPi * v), 0};
    const auto y = quadric_surface<Scalar, false>(own, static_cast<std::uint32_t>(own.kind), x);
    largest = std::max(largest, instance.offset(y.p, y.ng, y.offset));
  }
  return 1.5f * largest;
}

/// The quadric of an instance in world space.
QuadricRow place_quadric(const QuadricRow& own, const InstanceRow& instance) {
  Matrix4 inner, outer;
  for (std::size_t i = 0; i < 12; ++i) {
    inner.m[i / 4][i % 4] = own.to_world[i];
    outer.m[i / 4][i % 4] = instance.to_world[i];
  }
  return make_quadric(own.kind, Transform(outer * inner), own.normal_sign < 0.0f);
}

}  // namespace

Vec3f QuadricLightKind::power(const SceneView& scene, const LightRow& light) {
  return emitted_rgb(light) *
         (exitance_factor(light) * quadric_area(scene.geometry.quadrics[light.data<QuadricLightData>().quadric]));
}

LightBounds QuadricLightKind::bounds(const SceneView& scene, const LightRow& light, double power) {
  const QuadricRow& quadric = scene.geometry.quadrics[light.data<QuadricLightData>().quadric];
  const double area = double{sides_of(light)} * quadric_area(quadric);
  LightBounds out = quadric_light_bounds(quadric, static_cast<float>(power / (double(kPi) * area)));
  out.two_sided = light.is_two_sided();
  return out;
}

/// Mean of the texture.
Vec3f QuadricLightKind::integral(const SceneView& scene, const LightRow& light, int points) {
  const QuadricRow& row = scene.geometry.quadrics[light.data<QuadricLightData>().quadric];
  TextureMean mean(scene, light.texture);
  for (int k = 0; k < points; ++k) {
    const Vec2f u = spread_point(k);
    Vec3f x = square_to_sphere<Scalar>(u.x, u.y), normal = x;
    if (row.kind == ShapeKind::kDisk) {
      const Vec2f d = square_to_disk<Scalar>(u.x, u.y);
      x = {d.x, d.y, 0};
      normal = {0, 0, 1};
    } else if (row.kind == ShapeKind::kCylinder) {
      const auto angle = sincos_2pi<Scalar>(u.x);
      x = {angle.cos, angle.sin, u.y};
      normal = {angle.cos, angle.sin, 0};
    }
    const auto y = quadric_surface<Scalar, true>(row, static_cast<std::uint32_t>(row.kind), x);
    mean.add({y.uv, light.data<QuadricLightData>().shape, 0, 0, 0}, length(row.world_normal(normal)));
  }
  return mean.value();
}

/// The kind of shape and, unless it is similar to the canonical one, the scalar products of the rows of its inverse,
/// which determine the scaling of area elements.
IntegralSharing QuadricLightKind::integral_key(const SceneView& scene, const LightRow& light,
                                               std::vector<std::uint32_t>& key) {
  if (light.texture == kNone) return IntegralSharing::kNoIntegral;
  const QuadricRow& row = scene.geometry.quadrics[light.data<QuadricLightData>().quadric];
  key.push_back(static_cast<std::uint32_t>(row.kind));
  if (row.uniform_scale > 0.0f) return IntegralSharing::kShared;
  const auto product = [&](int i, int j) {
    const float *a = row.to_object + 4 * i, *b = row.to_object + 4 * j;
    return double{a[0]} * b[0] + double{a[1]} * b[1] + double{a[2]} * b[2];
  };
  const double trace = product(0, 0) + product(1, 1) + product(2, 2);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) key.push_back(rounded_fraction(static_cast<float>(product(i, j) / trace)));
  return IntegralSharing::kShared;
}

void complete_quadric_light(AreaLight& light, const ShapeRow& shape, std::uint32_t shape_index,
                            const ShapeTables& tables, const LightTableOffsets& offsets,
                            const LightInstance* instance) {
  QuadricRow q = tables.quadrics[shape.first_triangle];
  QuadricLightData<Scalar> data{shape_index, offsets.quadric, canonical_area(q.kind), 0.0f};
  if (instance != nullptr) {
    data.min_offset = quadric_offset(q, *instance);
    q = place_quadric(q, instance->rest);
    light.quadric = q;
  }
  // A flipped sphere emits inwards, where sampling the cone of visible directions does not apply.
  const bool outwards = q.normal_sign > 0.0f && !light.row.is_two_sided();
  const bool cone = q.kind == ShapeKind::kSphere && q.uniform_scale > 0.0f && outwards;
  light.area = quadric_area(q);
  light.row.kind = static_cast<std::uint32_t>(cone ? kLightKind<SphereLightKind> : kLightKind<QuadricLightKind>);
  if (cone) {
    const Vec3f center{q.to_world[3], q.to_world[7], q.to_world[11]};
    light.row.set_data(SphereLightData<Scalar>{data, center, q.uniform_scale});
  } else {
    light.row.set_data(data);
  }
}

LightBounds quadric_light_bounds(const QuadricRow& row, float radiance) {
  const Bounds3f box = quadric_bounds(row);
  LightBounds out;
  out.lower = box.min;
  out.upper = box.max;
  const double area = quadric_area(row);
  if (row.kind == ShapeKind::kDisk) {
    // The inverse transpose maps (0, 0, 1) to the third row of the inverse.
    const double n[3] = {row.to_object[8], row.to_object[9], row.to_object[10]};
    const double scale = row.normal_sign / std::hypot(n[0], n[1], n[2]);
    out.axis = {static_cast<float>(n[0] * scale), static_cast<float>(n[1] * scale), static_cast<float>(n[2] * scale)};
    out.cos_theta_o = 1;
    out.power = peak_power(radiance * area);
    return out;
  }
  // Seen from the side, the projected area of a sphere is 1/4 of its area, that of a cylinder 1 / pi.
  out.power = peak_power(radiance * area * (row.kind == ShapeKind::kSphere ? 0.25 : double(kInvPi)));
  return out;
}

}  // namespace sheaf

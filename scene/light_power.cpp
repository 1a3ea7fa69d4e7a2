// The power of lights: closed forms, and for textures a mean over points that are spread evenly.
#include "scene/light.h"
#include "scene/quadric.h"
#include "scene/shape.h"
#include "scene/texture_lookup.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr int kPoints = 4096;
constexpr double kPiDouble = 3.14159265358979323846;

/// Point i of n of an additive recurrence over the unit square (Roberts, "The Unreasonable Effectiveness of
/// Quasirandom Sequences", 2018).
Vec2f spread_point(int i) {
  constexpr double kX = 0.7548776662466927, kY = 0.5698402909980532;
  const double x = 0.5 + kX * i, y = 0.5 + kY * i;
  return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

struct Mean {
  double r = 0, g = 0, b = 0, weight = 0;

  void add(const SceneView& scene, std::uint32_t texture, const TextureQuery<Scalar>& query, double w) {
    const Spectrum4 value = lookup_texture<Scalar>(scene.textures, texture, query);
    r += w * std::max(value.c0, 0.0f);
    g += w * std::max(value.c1, 0.0f);
    b += w * std::max(value.c2, 0.0f);
    weight += w;
  }
  Vec3f value() const {
    const double scale = weight > 0.0 ? 1.0 / weight : 0.0;
    return {static_cast<float>(r * scale), static_cast<float>(g * scale), static_cast<float>(b * scale)};
  }
};

Vec3f mean_over_mesh(const SceneView& scene, const LightRow& light) {
  Mean mean;
  int next = 0;
  for (std::uint32_t i = 0; i < light.triangle_count; ++i) {
    const double share = scene.triangle_alias[light.first_triangle + i].pdf;
    const int points = std::clamp(static_cast<int>(std::ceil(share * kPoints)), 1, kPoints);
    const float* uv = scene.light_uvs[light.detail + i].uv;
    for (int k = 0; k < points; ++k) {
      const Vec2f u = spread_point(next++);
      const Vec2f b = square_to_triangle<Scalar>(u.x, u.y);
      const float b0 = 1 - b.x - b.y;
      const Vec2f at{b0 * uv[0] + b.x * uv[2] + b.y * uv[4], b0 * uv[1] + b.x * uv[3] + b.y * uv[5]};
      mean.add(scene, light.texture, {at, light.shape, i, b.x, b.y}, share / points);
    }
  }
  return mean.value();
}

Vec3f mean_over_quadric(const SceneView& scene, const LightRow& light) {
  const QuadricRow& row = scene.quadrics[light.first_triangle];
  const auto q = load_quadrics<Scalar>(scene, light.first_triangle);
  Mean mean;
  for (int k = 0; k < kPoints; ++k) {
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
    const auto y = quadric_surface<Scalar, true>(q, static_cast<std::uint32_t>(row.kind), x);
    mean.add(scene, light.texture, {y.uv, light.shape, 0, 0, 0}, length(q.world_normal(normal)));
  }
  return mean.value();
}

/// Share of the intensity that a spot keeps at an angle from its axis.
double spot_falloff(const LightRow& light, const float* words, double theta) {
  if (light.kind == static_cast<std::uint32_t>(LightKind::kSpot))
    return std::clamp((words[0] - theta) * words[1], 0.0, 1.0);
  const double t = std::clamp((std::cos(theta) - words[0]) * words[1], 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Integral of a spot's intensity over directions for an intensity of 1.
Vec3f spot_integral(const SceneView& scene, const LightRow& light) {
  const float* words = scene.light_frames[light.detail].words;
  const bool linear = light.kind == static_cast<std::uint32_t>(LightKind::kSpot);
  const double cutoff = linear ? words[0] : std::acos(std::clamp(double(words[0]), -1.0, 1.0));
  Mean mean;
  double sum = 0;
  constexpr int kRings = 512;
  for (int i = 0; i < kRings; ++i) {
    const double theta = (i + 0.5) / kRings * cutoff;
    const double weight = spot_falloff(light, words, theta) * std::sin(theta) * cutoff / kRings;
    sum += weight;
    if (light.texture == kNone) continue;
    constexpr int kAround = 32;
    for (int j = 0; j < kAround; ++j) {
      const double phi = 2.0 * kPiDouble * (j + 0.5 + 0.618 * i) / kAround, r = 0.5 * std::tan(theta) * words[2];
      const Vec2f uv{static_cast<float>(0.5 + r * std::cos(phi)), static_cast<float>(0.5 + r * std::sin(phi))};
      mean.add(scene, light.texture, {uv, 0, 0, 0, 0}, weight);
    }
  }
  const auto whole = static_cast<float>(2.0 * kPiDouble * sum);
  return light.texture == kNone ? Vec3f{whole, whole, whole} : mean.value() * whole;
}

/// The same for a projector: the picture's integral over its rectangle at distance 1.
Vec3f projector_integral(const SceneView& scene, const LightRow& light) {
  const float* words = scene.light_frames[light.detail].words;
  const float area = 1.0f / (words[0] * words[1]);
  if (light.texture == kNone) return {area, area, area};
  Mean mean;
  for (int k = 0; k < kPoints; ++k) mean.add(scene, light.texture, {spread_point(k), 0, 0, 0, 0}, 1.0);
  return mean.value() * area;
}

float surface_area(const SceneView& scene, const LightRow& light) {
  const bool mesh = light.kind == static_cast<std::uint32_t>(LightKind::kMesh);
  return mesh ? light.area : quadric_area(scene.quadrics[light.first_triangle]);
}

}  // namespace

bool is_infinite(const LightRow& light) {
  const auto kind = static_cast<LightKind>(light.kind);
  return kind == LightKind::kConstant || kind == LightKind::kEnvmap || kind == LightKind::kDirectional;
}

Vec3f light_power(const SceneView& scene, std::uint32_t index) {
  const LightRow& light = scene.lights[index];
  const Vec3f emitted{light.radiance[0], light.radiance[1], light.radiance[2]};
  const float disk = kPi * scene.radius * scene.radius;
  switch (static_cast<LightKind>(light.kind)) {
    case LightKind::kPoint:
    case LightKind::kVolume:
      return emitted * (4 * kPi);
    case LightKind::kConstant:
    case LightKind::kEnvmap:
      return emitted * (4 * kPi * disk);
    case LightKind::kDirectional:
      return emitted * disk;
    case LightKind::kSpot:
    case LightKind::kSmoothSpot:
      return emitted * spot_integral(scene, light);
    case LightKind::kProjector:
      return emitted * projector_integral(scene, light);
    default:
      break;
  }
  const Vec3f power = emitted * (kPi * surface_area(scene, light));
  if (light.texture == kNone) return power;
  return power * (light.kind == static_cast<std::uint32_t>(LightKind::kMesh) ? mean_over_mesh(scene, light)
                                                                             : mean_over_quadric(scene, light));
}

}  // namespace sheaf

// Collects the casters and the lights of a scene.
#include "kernels/caustics/casters.h"

#include "core/sampling/warp.h"
#include "kernels/lights/list.h"
#include "scene/materials/list.h"
#include "scene/surfaces/shape.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

bool is_glass(const MaterialRow& material) {
  return material.kind == kClosureKind<DielectricClosure> || material.kind == kClosureKind<DispersiveDielectricClosure>;
}

/// Whether a material is perfectly specular with parameters that are the same everywhere.
bool is_specular(const MaterialRow& material) {
  return (is_glass(material) || material.kind == kClosureKind<ConductorClosure>)&&material.binding_count == 0 &&
         (material.flags & (kMapped | kComposite | kPart)) == 0;
}

constexpr std::uint32_t kNotCaster = kNone - 1;

float triangle_area(const SceneView& scene, const ShapeRow& shape, std::uint32_t triangle) {
  const CasterTriangle t = caster_triangle(scene, shape, triangle, 0);
  return 0.5f * length(cross(t.p[1] - t.p[0], t.p[2] - t.p[0]));
}

/// Surface area of a shape, m^2; approximate for quadrics. In the space of the shape when the shutter opens.
float area(const SceneView& scene, const ShapeRow& shape) {
  if (static_cast<ShapeKind>(shape.kind) != ShapeKind::kMesh) {
    const float scale = std::cbrt(scene.geometry.quadrics[shape.first_triangle].determinant);
    return 4 * kPi * scale * scale;
  }
  float sum = 0;
  for (std::uint32_t i = 0; i < shape.triangle_count; ++i) sum += triangle_area(scene, shape, i);
  return sum;
}

bool is_supported(const ShapeRow& shape) {
  const auto kind = static_cast<ShapeKind>(shape.kind);
  return (kind == ShapeKind::kMesh && shape.triangle_count > 0) || kind == ShapeKind::kSphere ||
         kind == ShapeKind::kDisk || kind == ShapeKind::kCylinder;
}

/// A point on the canonical shape of a quadric.
Vec3f canonical_point(ShapeKind kind, float u, float v) {
  if (kind == ShapeKind::kSphere) return square_to_sphere<Scalar>(u, v);
  if (kind == ShapeKind::kCylinder) {
    const auto angle = sincos_2pi<Scalar>(u);
    return {angle.cos, angle.sin, v};
  }
  const Vec2f on_disk = square_to_disk<Scalar>(u, v);
  return {on_disk.x, on_disk.y, 0};
}

}  // namespace

bool ends_chains(const LightRow& light) {
  LightHitKind kind = LightHitKind::kEscape;
  Lights::for_each([&]<class Light>(Light) {
    if (!kIsForPhotons<Light> && light.is(kLightKind<typename Light::Kind>)) kind = Light::kHitKind;
  });
  const bool is_reached = !light.is_along_normal() && !light.has_flag(kMissedByRays);
  return kind == LightHitKind::kNever || (kind == LightHitKind::kSurface && is_reached);
}

CasterTriangle caster_triangle(const SceneView& scene, const ShapeRow& shape, std::uint32_t triangle, float time) {
  const std::uint32_t* row = scene.geometry.triangles + std::size_t{3} * (shape.first_triangle + triangle);
  const VertexRow* vertices = scene.geometry.vertices + shape.first_vertex;
  const std::uint32_t corners[3] = {row[0], row[1], row[2]};
  CasterTriangle out;
  for (int k = 0; k < 3; ++k) out.p[k] = vertices[corners[k]].position, out.n[k] = vertices[corners[k]].normal;
  if (scene.motion.deformations != nullptr) {
    Vec3f extent{0, 0, 0};
    deform_triangles<Scalar>(scene, shape, true, corners, time, out.p, out.n, extent);
  }
  return out;
}

std::optional<InstancePlacement<Scalar>> caster_placement(const SceneView& scene, std::uint32_t instance, float time) {
  if (instance == kNone) return {};
  return placement_at<Scalar>(scene.motion, scene.geometry.instances[instance], instance, true, time).placed;
}

CausticCasters::CausticCasters(const SceneView& scene) : instance_of_(scene.geometry.shape_count, kNotCaster) {
  // Find the instances of moving shapes
  std::vector<std::uint32_t> instances(scene.geometry.shape_count, kNone);
  for (std::uint32_t i = scene.motion.first_moving_shape; i < scene.motion.end_of_moving_shapes; ++i)
    instances[scene.geometry.instances[i].first_shape] = i;
  // Collect the casters
  std::vector<float> weights;
  for (std::uint32_t i = 0; i < scene.geometry.shape_count; ++i) {
    const ShapeRow& shape = scene.geometry.shapes[i];
    if (shape.light != kNone || (shape.flags & kUntraced) != 0 || !is_supported(shape)) continue;
    const MaterialRow& front = scene.materials.rows[shape.material];
    float size = area(scene, shape);
    if (const auto placed = caster_placement(scene, instances[i], 0)) {
      const float scale = std::cbrt(std::fabs(placed->determinant));
      size *= scale * scale;
    }
    if (!is_specular(front) || !is_specular(scene.materials.rows[front.back]) || !(size > 0) || !is_finite(size))
      continue;
    instance_of_[i] = instances[i];
    has_glass_ = has_glass_ || is_glass(front);
    casters_.push_back(i);
    weights.push_back(size);
  }
  if (!casters_.empty()) caster_alias_ = build_alias_table(weights);
  // Collect the lights
  weights.clear();
  for (std::uint32_t i = 0; i < scene.lights.count; ++i) {
    const float power = scene.lights.alias[i].pdf;
    if (!ends_chains(scene.lights.rows[i]) || !(power > 0)) continue;
    lights_.push_back(i);
    weights.push_back(power);
  }
  if (!lights_.empty()) light_alias_ = build_alias_table(weights);
  light_probability_.resize(scene.lights.count);
  for (std::size_t i = 0; i < lights_.size(); ++i) light_probability_[lights_[i]] = light_alias_[i].pdf;
}

Vec3f CausticCasters::sample_point(const SceneView& scene, const Random4<Scalar>& u, float time) const {
  const auto count = static_cast<std::uint32_t>(casters_.size());
  const std::uint32_t index = casters_[sample_alias<Scalar>(caster_alias_.data(), 0, count, u.x).index];
  const ShapeRow& shape = scene.geometry.shapes[index];
  const auto kind = static_cast<ShapeKind>(shape.kind);
  const auto placed = caster_placement(scene, instance_of_[index], time);
  const auto in_world = [&](Vec3f p) { return placed ? placed->point(p) : p; };
  if (kind != ShapeKind::kMesh)
    return in_world(scene.geometry.quadrics[shape.first_triangle].world_point(canonical_point(kind, u.y, u.z)));
  const auto triangle =
      std::min(static_cast<std::uint32_t>(u.w * static_cast<float>(shape.triangle_count)), shape.triangle_count - 1);
  const Vec2f b = square_to_triangle<Scalar>(u.y, u.z);
  const CasterTriangle t = caster_triangle(scene, shape, triangle, time);
  return in_world(t.p[0] + (t.p[1] - t.p[0]) * b.x + (t.p[2] - t.p[0]) * b.y);
}

CausticCasters::Light CausticCasters::sample_light(float u) const {
  const auto sample = sample_alias<Scalar>(light_alias_.data(), 0, static_cast<std::uint32_t>(lights_.size()), u);
  return {lights_[sample.index], sample.pdf};
}

}  // namespace sheaf

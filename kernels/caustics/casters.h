// The surfaces that cast caustics and the lights that shine on them, for manifold next-event estimation (Zeltner,
// Georgiev and Jakob, "Specular Manifold Sampling for Rendering High-Frequency Caustics and Glints", 2020).
#pragma once

#include "core/sampling/alias_table.h"
#include "core/sampling/rng.h"
#include "scene/tables/instance.h"
#include "scene/tables/scene_view.h"

#include <optional>
#include <vector>

namespace sheaf {

/// Maximum number of specular vertices between a vertex and the light.
inline constexpr int kMaxChainLength = 4;

/// A triangle of a caster in the space of its shape.
struct CasterTriangle {
  Vec3f p[3], n[3];  ///< positions; vertex normals, or zero
};

/// Triangle of the mesh of a shape, which may deform, at a time in [0, 1].
CasterTriangle caster_triangle(const SceneView& scene, const ShapeRow& shape, std::uint32_t triangle, float time);

/// Placement of a caster at a time in [0, 1]. Empty without an instance: its tables are in world space.
std::optional<InstancePlacement<Scalar>> caster_placement(const SceneView& scene, std::uint32_t instance, float time);

/// Casters: meshes, spheres, disks and cylinders outside of groups that do not emit and whose material is a smooth
/// dielectric or conductor on both sides, without textures and normal maps. They may move and deform.
class CausticCasters {
 public:
  explicit CausticCasters(const SceneView& scene);

  /// Whether there is nothing to connect: no caster or no light.
  bool empty() const { return casters_.empty() || lights_.empty(); }
  /// Whether the shape that a ray has hit is a caster. `shape`, `instance`: as in HitState.
  bool is_caster(std::uint32_t shape, std::uint32_t instance) const {
    return shape != kNone && instance_of_[shape] == instance;
  }
  /// Whether any caster is a dielectric.
  bool has_glass() const { return has_glass_; }

  /// A point on a caster at a time in [0, 1], with a positive density everywhere; also on shapes of groups, as if they
  /// were not instanced. The casters are chosen by area, the triangles of a mesh uniformly.
  Vec3f sample_point(const SceneView& scene, const Random4<Scalar>& u, float time) const;

  /// A light and the probability of choosing it.
  struct Light {
    std::uint32_t row;  ///< of LightView::rows
    float probability;
  };
  /// Chooses among area lights and lights at a point or in a direction, by power and by u in [0, 1).
  Light sample_light(float u) const;
  /// The probability with which sample_light() chooses the light of that row.
  float light_probability(std::uint32_t row) const { return light_probability_[row]; }

 private:
  /// By shape: the instance that makes it move, kNone for shapes without a motion, kNotCaster for those that cast none.
  std::vector<std::uint32_t> instance_of_;
  std::vector<std::uint32_t> casters_;  ///< shapes
  std::vector<AliasEntry> caster_alias_;
  std::vector<std::uint32_t> lights_;  ///< rows
  std::vector<AliasEntry> light_alias_;
  std::vector<float> light_probability_;  ///< by row
  bool has_glass_ = false;
};

/// Whether a chain may end at a light: an area light that emits in all directions of a hemisphere, or a light at a
/// point or in a direction.
bool ends_chains(const LightRow& light);

}  // namespace sheaf

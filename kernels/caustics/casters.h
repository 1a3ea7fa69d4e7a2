// The surfaces that cast caustics and the lights that shine on them, for manifold next-event estimation (Zeltner,
// Georgiev and Jakob, "Specular Manifold Sampling for Rendering High-Frequency Caustics and Glints", 2020).
#pragma once

#include "core/alias_table.h"
#include "core/rng.h"
#include "scene/tables/scene.h"

#include <vector>

namespace sheaf {

/// Maximum number of specular vertices between a vertex and the light.
inline constexpr int kMaxChainLength = 4;

/// Casters: meshes, spheres, disks and cylinders outside of groups that do not emit and whose material is a smooth
/// dielectric or conductor on both sides, without textures and normal maps.
class CausticCasters {
 public:
  explicit CausticCasters(const SceneView& scene);

  /// Whether there is nothing to connect: no caster or no light.
  bool empty() const { return casters_.empty() || lights_.empty(); }
  /// Whether the shape that a ray has hit is a caster. `shape`, `instance`: as in HitState.
  bool is_caster(std::uint32_t shape, std::uint32_t instance) const {
    return instance == kNone && shape != kNone && is_caster_[shape] != 0;
  }
  /// Whether any caster is a dielectric.
  bool has_glass() const { return has_glass_; }

  /// A point on a caster, with a positive density everywhere; also on shapes of groups, as if they were not instanced.
  /// The casters are chosen by area, the triangles of a mesh uniformly.
  Vec3f sample_point(const SceneView& scene, const Random4<Scalar>& u) const;

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
  std::vector<std::uint8_t> is_caster_;  ///< by shape
  std::vector<std::uint32_t> casters_;   ///< shapes
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

#include "scene/lights/light_powers.h"

#include "scene/lights/texture_mean.h"
#include "scene/tables/light_tree.h"
#include "scene/tables/scene_view.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

namespace sheaf {

namespace {

/// Groups the lights that share an integral in their power.
class IntegralGroups {
 public:
  explicit IntegralGroups(const SceneView& scene) {
    std::map<std::vector<std::uint32_t>, std::size_t> known;
    for (std::uint32_t light = 0; light < scene.lights.count; ++light) {
      const LightRow& row = scene.lights.rows[light];
      const LightCompiler& compiler = light_compiler_of(row);
      if (compiler.integral == nullptr) continue;
      std::vector<std::uint32_t> key{row.kind, row.texture};
      const IntegralSharing sharing = compiler.integral_key(scene, row, key);
      if (sharing == IntegralSharing::kNoIntegral) continue;
      std::size_t group = firsts_.size();
      if (sharing == IntegralSharing::kShared &&
          (row.texture == kNone || (scene.textures.rows[row.texture].needs & kTextureNeedsMesh) == 0))
        group = known.emplace(std::move(key), group).first->second;
      if (group == firsts_.size()) firsts_.push_back(light);
      members_.emplace_back(light, group);
    }
  }

  /// The first light of each group.
  const std::vector<std::uint32_t>& firsts() const { return firsts_; }
  /// Pairs of a light and its group.
  const std::vector<std::pair<std::uint32_t, std::size_t>>& members() const { return members_; }

 private:
  std::vector<std::uint32_t> firsts_;
  std::vector<std::pair<std::uint32_t, std::size_t>> members_;
};

}  // namespace

Vec3f light_power(const SceneView& scene, std::uint32_t light) {
  const LightRow& row = scene.lights.rows[light];
  const LightCompiler& compiler = light_compiler_of(row);
  const Vec3f power = compiler.power(scene, row);
  std::vector<std::uint32_t> key;
  if (compiler.integral == nullptr || compiler.integral_key(scene, row, key) == IntegralSharing::kNoIntegral)
    return power;
  return power * compiler.integral(scene, row, kMeanPoints);
}

std::vector<Vec3f> light_powers(const SceneView& scene) {
  // Total number of points for all integrals, and minimum number for each
  constexpr std::size_t kMaxPoints = 1 << 20, kMinPoints = 256;
  const IntegralGroups groups(scene);
  const std::size_t points_per_integral = kMaxPoints / std::max<std::size_t>(groups.firsts().size(), 1);
  const int points = static_cast<int>(std::clamp<std::size_t>(points_per_integral, kMinPoints, kMeanPoints));
  std::vector<Vec3f> integrals, powers;
  for (const std::uint32_t light : groups.firsts()) {
    const LightRow& row = scene.lights.rows[light];
    integrals.push_back(light_compiler_of(row).integral(scene, row, points));
  }
  for (std::uint32_t light = 0; light < scene.lights.count; ++light) {
    const LightRow& row = scene.lights.rows[light];
    powers.push_back(light_compiler_of(row).power(scene, row));
  }
  for (const auto& [light, group] : groups.members()) powers[light] = powers[light] * integrals[group];
  return powers;
}

LightBounds bounds_of_light(const SceneView& scene, std::uint32_t light, double power) {
  const LightRow& row = scene.lights.rows[light];
  return light_compiler_of(row).bounds(scene, row, power);
}

}  // namespace sheaf

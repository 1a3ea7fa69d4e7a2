#include "scene/compile/light.h"

#include "scene/compile/lights/texture_mean.h"

#include <algorithm>
#include <array>
#include <map>
#include <span>
#include <utility>

namespace sheaf {

namespace {

/// Whether a texture, or a part of it, is a volume.
bool holds_volume(std::span<const TextureRow> rows, std::uint32_t texture) {
  const TextureRow& row = rows[texture];
  if (row.kind != TextureKind::kCheckerboard && row.kind != TextureKind::kGrid) return row.kind == TextureKind::kVolume;
  return holds_volume(rows, row.checkerboard.child[0]) || holds_volume(rows, row.checkerboard.child[1]);
}

/// Whether a texture or one of its inputs depends on the mesh.
bool depends_on_mesh(const TextureView& textures, std::uint32_t texture) {
  const TextureRow& row = textures.rows[texture];
  const auto any_of = [&](const std::uint32_t(&children)[2]) {
    return depends_on_mesh(textures, children[0]) || depends_on_mesh(textures, children[1]);
  };
  switch (row.kind) {
    case TextureKind::kConstant:
    case TextureKind::kBitmap:
    case TextureKind::kVolume:
      return false;
    case TextureKind::kCheckerboard:
    case TextureKind::kGrid:
      return any_of(row.checkerboard.child);
    case TextureKind::kMix:
      return any_of(row.mix.child) || depends_on_mesh(textures, row.mix.amount);
    case TextureKind::kMeshAttribute:
    case TextureKind::kWireframe:
      return true;
  }
  return true;
}

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
      if (sharing == IntegralSharing::kOne) continue;
      std::size_t group = firsts_.size();
      if (sharing == IntegralSharing::kAll && (row.texture == kNone || !depends_on_mesh(scene.textures, row.texture)))
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

SpectrumRow LightContext::emission_row(const SpectrumInput& emission, const SourceLocation& where) const {
  if (spectra == nullptr) return {};
  const auto* spectrum = std::get_if<SpectrumDescription>(&emission);
  try {
    return spectra->row(spectrum != nullptr ? *spectrum : SpectrumDescription::constant(1), SpectrumUse::kIlluminant);
  } catch (const SceneError& error) { throw SceneError(where, error.what()); }
}

std::uint32_t LightContext::texture_row(TextureId id, const SourceLocation& where) const {
  if (static_cast<std::size_t>(id) >= description.textures.size())
    throw SceneError(where, "refers to a texture that does not exist");
  if (holds_volume(textures, static_cast<std::uint32_t>(id)))
    throw SceneError(where,
                     "shines by a texture that is a grid in the world, expected one that follows the surface: "
                     "lights are looked up by uv");
  return static_cast<std::uint32_t>(id);
}

LightRow make_light_row(LightKind kind, Vec3f radiance, Vec3f position) {
  LightRow row;
  row.kind = static_cast<std::uint32_t>(kind);
  row.radiance = {radiance.x, radiance.y, radiance.z, 0.0f};
  row.position = position;
  return row;
}

const LightCompiler& light_compiler_of(const LightRow& light) {
  static const auto kAll = []<std::size_t... Kind>(std::index_sequence<Kind...>) {
    return std::array{light_compiler(LightTag<static_cast<LightKind>(Kind)>{})...};
  }
  (std::make_index_sequence<kLightKinds>{});
  return kAll[light.kind];
}

bool is_infinite(const LightRow& light) { return light_compiler_of(light).domain != LightDomain::kBounded; }

Vec3f light_power(const SceneView& scene, std::uint32_t light) {
  const LightRow& row = scene.lights.rows[light];
  const LightCompiler& compiler = light_compiler_of(row);
  const Vec3f power = compiler.power(scene, row);
  std::vector<std::uint32_t> key;
  if (compiler.integral == nullptr || compiler.integral_key(scene, row, key) == IntegralSharing::kOne) return power;
  return power * compiler.integral(scene, row, kMeanPoints);
}

std::vector<Vec3f> light_powers(const SceneView& scene) {
  // Total number of points for all integrals, and minimum number for each
  constexpr std::size_t kMaxPoints = 1 << 20, kMinPoints = 256;
  const IntegralGroups groups(scene);
  const std::size_t share = kMaxPoints / std::max<std::size_t>(groups.firsts().size(), 1);
  const int points = static_cast<int>(std::clamp<std::size_t>(share, kMinPoints, kMeanPoints));
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

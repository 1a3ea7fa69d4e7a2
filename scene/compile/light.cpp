#include "scene/compile/light.h"

#include <array>
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
  }(std::make_index_sequence<kLightKinds>{});
  return kAll[light.kind];
}

bool is_infinite(const LightRow& light) { return light_compiler_of(light).reach != LightReach::kBounded; }

Vec3f light_power(const SceneView& scene, std::uint32_t light) {
  const LightRow& row = scene.lights[light];
  return light_compiler_of(row).power(scene, row);
}

LightBounds bounds_of_light(const SceneView& scene, std::uint32_t light, double power) {
  const LightRow& row = scene.lights[light];
  return light_compiler_of(row).bounds(scene, row, power);
}

}  // namespace sheaf

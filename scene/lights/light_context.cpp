#include "scene/lights/light_context.h"

#include "scene/description/description.h"
#include "scene/spectra/spectrum_rgb.h"
#include "scene/spectra/spectrum_set.h"

namespace sheaf {

namespace {

/// Whether a texture, or a part of it, is a volume.
bool holds_volume(std::span<const TextureRow> rows, std::uint32_t texture) {
  const TextureRow& row = rows[texture];
  if (row.kind != TextureKind::kCheckerboard && row.kind != TextureKind::kGrid) return row.kind == TextureKind::kVolume;
  return holds_volume(rows, row.checkerboard.child[0]) || holds_volume(rows, row.checkerboard.child[1]);
}

}  // namespace

LightEmission LightContext::emission(const SpectrumInput& emission, const SourceLocation& where) const {
  const auto* spectrum = std::get_if<SpectrumDescription>(&emission);
  return {spectrum != nullptr ? emission_rgb(*spectrum) : Vec3f{1, 1, 1}, emission_row(emission, where)};
}

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

LightRow make_light_row(LightKind kind, Vec3f radiance) {
  LightRow row;
  row.kind = static_cast<std::uint32_t>(kind);
  row.radiance = {radiance.x, radiance.y, radiance.z, 0.0f};
  return row;
}

std::uint32_t LightContext::add_frame(const LightFrameRow& frame) {
  frames.push_back(frame);
  return static_cast<std::uint32_t>(frames.size() - 1);
}

}  // namespace sheaf

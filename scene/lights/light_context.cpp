#include "scene/lights/light_context.h"

#include "scene/spectra/spectrum_rgb.h"
#include "scene/spectra/spectrum_set.h"

namespace sheaf {

LightEmission LightContext::emission(const SpectrumInput& emission, const SourceLocation& where) const {
  const auto* spectrum = std::get_if<SpectrumDescription>(&emission);
  return {spectrum != nullptr ? emission_rgb(*spectrum) : Vec3f{1, 1, 1}, emission_row(emission, where)};
}

SpectrumRow LightContext::emission_row(const SpectrumInput& emission, const SourceLocation& where) const {
  if (spectra == nullptr) return {};
  const auto* spectrum = std::get_if<SpectrumDescription>(&emission);
  try {
    return spectra->row(spectrum != nullptr ? *spectrum : SpectrumDescription::constant(1), SpectrumUse::kIlluminant);
  } catch (const SceneError& error) { throw SceneError(where, error); }
}

std::uint32_t LightContext::texture_row(TextureId id, const SourceLocation& where) const {
  if (static_cast<std::size_t>(id) >= textures.size())
    throw SceneError(where, "refers to a texture that does not exist");
  if ((textures[static_cast<std::uint32_t>(id)].needs & kTextureNeedsPoint) != 0)
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

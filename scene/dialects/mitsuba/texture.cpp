// The Mitsuba dialect: textures.
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_spectrum.h"
#include "scene/dialects/xml/read_texture.h"
#include "scene/dialects/xml/read_volume.h"

namespace sheaf::mitsuba {

namespace {

/// Reads a volume evaluated on surfaces: a color, or a grid looked up at the world-space position.
SpectrumInput read_volume_texture(Properties& p) {
  const VolumeInput volume = volume_input(p, "volume", SpectrumDescription::constant(0.75f), SpectrumRole::kIor, {});
  const auto* grid = std::get_if<GridVolumeDescription>(&volume);
  if (grid != nullptr) {
    TextureDescription texture;
    texture.model = VolumeTextureDescription{*grid};
    return add_texture(p, std::move(texture));
  }
  p.reject_unused();
  return std::get<SpectrumDescription>(volume);
}

/// Returns a copy of the texture with its values scaled by `by`.
SpectrumInput scaled_input(Properties& p, const SpectrumInput& input, float by, int depth = 0) {
  if (const auto* constant = std::get_if<SpectrumDescription>(&input)) return scaled(*constant, by);
  constexpr int kMaxNesting = 8;
  if (depth > kMaxNesting) p.fail("has textures nested deeper than 8 levels", SceneErrorCode::kTooLarge);
  std::vector<TextureDescription>& textures = p.context().description.textures;
  TextureDescription copy = textures.at(static_cast<std::size_t>(std::get<TextureId>(input)));
  copy.model = scaled_texture(std::move(copy.model), by,
                              [&](const SpectrumInput& color) { return scaled_input(p, color, by, depth + 1); });
  textures.push_back(std::move(copy));
  return static_cast<TextureId>(textures.size() - 1);
}

/// Reads a texture scaled by a constant factor.
SpectrumInput read_scaled(Properties& p) {
  const float by = p.number("scale", 1, kNotNegative);
  const XmlElement* nested = p.any_texture_or_color();
  if (nested == nullptr) p.fail("needs a nested <texture>", SceneErrorCode::kMissing);
  SpectrumInput result = scaled_input(p, texture_of(*nested, p.context()), by);
  p.reject_unused();
  p.context().textures.emplace(&p.element(), result);
  return result;
}

/// Textures that may be constant.
constexpr NameTable<SpectrumInput (*)(Properties&)> kInputs{{{"scale", read_scaled}, {"volume", read_volume_texture}}};

}  // namespace

SpectrumInput texture_of(const XmlElement& element, ReadContext& context) {
  if (const SpectrumInput* known = find_read_texture(element, context)) return *known;
  if (element.name != "texture") return read_spectrum(element, context);
  if (kSpectrumPlugins.find(element.attribute("type")) != nullptr) return read_spectrum(element, context);
  Properties p(element, context);
  if (const auto* read = kInputs.find(p.type())) return (*read)(p);
  TextureDescription texture;
  std::vector<std::string> others = kSpectrumPlugins.names();
  for (const std::string& name : kInputs.names()) others.push_back(name);
  find_plugin<TexturePlugin>(p, {texture_plugins()}, std::move(others)).read(p, ImageOrigin::kUpperLeft, texture);
  return add_texture(p, std::move(texture));
}

}  // namespace sheaf::mitsuba

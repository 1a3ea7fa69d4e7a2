// The Nori dialect: its own textures; all others are shared with Mitsuba, with the image origin at the lower left.
#include "scene/dialects/nori/reader.h"
#include "scene/dialects/xml/read_spectrum.h"
#include "scene/dialects/xml/read_texture.h"

namespace sheaf::nori {

namespace {

/// Reads `scale`, the size of a repeated unit in uv, and `delta`, its uv offset.
std::array<float, 6> read_placement(Properties& p, float repeated) {
  Vec2f scale = p.vec2("scale", {1, 1});
  const Vec2f delta = p.vec2("delta", {0, 0});
  if (scale.x == 0 || scale.y == 0) {
    p.report_at("scale", "is 0 along an axis, expected other factors", SceneErrorCode::kOutOfRange);
    scale = {1, 1};
  }
  const float u = 1 / (repeated * scale.x), v = 1 / (repeated * scale.y);
  return {u, 0, -delta.x * u, 0, v, -delta.y * v};
}

/// Reads a checkerboard: value1 (default 0) in the square at `delta`, value2 (default 1) beside it. `scale` is the size
/// of a square.
void read_checkerboard(Properties& p, ImageOrigin, TextureDescription& texture) {
  const SpectrumDescription black = SpectrumDescription::constant(0), white = SpectrumDescription::constant(1);
  texture.model = CheckerboardDescription{p.spectrum_input("value1", black, SpectrumRole::kIor),
                                          p.spectrum_input("value2", white, SpectrumRole::kIor)};
  texture.to_uv = read_placement(p, 2);
}

/// Rejects a nonzero `eulerAngles`, because images are not rotated. Ignores `sphericalTexture`, because spheres always
/// have spherical texture coordinates.
void read_rotation(Properties& p) {
  if (p.vec3("eulerAngles", {0, 0, 0}) != Vec3f{0, 0, 0})
    p.report_at("eulerAngles", "is not 0 0 0: rotation of images is not supported", SceneErrorCode::kUnsupported);
  p.ignore({"sphericalTexture"});
}

SpectrumInput read_constant(Properties& p) {
  SpectrumInput value = p.spectrum_input("value", SpectrumDescription::constant(0), SpectrumRole::kIor);
  p.ignore({"filename", "eulerAngles", "sphericalTexture"});  // properties of the image that the constant replaces
  p.reject_unused();
  return value;
}

void read_image(Properties& p, ImageOrigin, TextureDescription& texture) {
  texture.model = BitmapDescription::read(p);
  texture.to_uv = read_placement(p, 1);
  read_rotation(p);
}

constexpr NameTable<SpectrumInput (*)(Properties&)> kConstants{
    {{"constant_color", read_constant}, {"constant_float", read_constant}}};

/// Textures of Nori; its forks have several names for a bitmap.
constexpr NameTable<TexturePluginReader> kTextures{{{"checkerboard_color", read_checkerboard},
                                                    {"checkerboard_float", read_checkerboard},
                                                    {"image", read_image},
                                                    {"imagetexture", read_image},
                                                    {"normaltexture", read_image},
                                                    {"png_texture", read_image}}};

}  // namespace

SpectrumInput texture_of(const XmlElement& element, ReadContext& context) {
  if (const SpectrumInput* known = find_read_texture(element, context)) return *known;
  if (element.name != "texture" || kSpectrumPlugins.find(element.attribute("type")) != nullptr)
    return read_spectrum(element, context);
  Properties p(element, context);
  if (const auto* read = kConstants.find(p.type())) return (*read)(p);
  TextureDescription texture;
  const TexturePluginReader* own = kTextures.find(p.type());
  std::vector<std::string> others = kSpectrumPlugins.names();
  for (const std::vector<std::string>& names : {kConstants.names(), kTextures.names()})
    others.insert(others.end(), names.begin(), names.end());
  const TexturePluginReader read =
      own != nullptr ? *own : find_plugin<TexturePlugin>(p, {texture_plugins()}, std::move(others)).read;
  read(p, ImageOrigin::kLowerLeft, texture);
  return add_texture(p, std::move(texture));
}

}  // namespace sheaf::nori

// The Nori dialect: its own textures; all others are shared with Mitsuba, with the image origin at the lower left.
#include "scene/dialects/common/read_spectrum.h"
#include "scene/dialects/common/read_texture.h"
#include "scene/dialects/nori/reader.h"

#include <algorithm>

namespace sheaf::nori {

namespace {

/// Reads `scale`, the size of a repeated unit in uv, and `delta`, its uv offset.
std::array<float, 6> read_placement(Properties& p, float repeated) {
  const Vec2f scale = p.find_vec2("scale").value_or(Vec2f{1, 1}), delta = p.find_vec2("delta").value_or(Vec2f{0, 0});
  if (scale.x == 0 || scale.y == 0) p.fail_at("scale", "is zero along an axis");
  const float u = 1 / (repeated * scale.x), v = 1 / (repeated * scale.y);
  return {u, 0, -delta.x * u, 0, v, -delta.y * v};
}

/// Reads a checkerboard: value1 (default 0) in the square at `delta`, value2 (default 1) beside it. `scale` is the size
/// of a square.
void read_checkerboard(Properties& p, TextureDescription& texture) {
  const SpectrumDescription black = SpectrumDescription::constant(0), white = SpectrumDescription::constant(1);
  texture.model = CheckerboardDescription{p.spectrum_input("value1", black, SpectrumRole::kIor),
                                          p.spectrum_input("value2", white, SpectrumRole::kIor)};
  texture.to_uv = read_placement(p, 2);
}

/// Whether the type is one of the names that forks of Nori use for a bitmap.
bool is_picture(const std::string& type) {
  return type == "image" || type == "imagetexture" || type == "png_texture" || type == "normaltexture";
}

/// Rejects a nonzero `eulerAngles`, because images are not rotated. Ignores `sphericalTexture`, because spheres always
/// have spherical texture coordinates.
void read_turn(Properties& p) {
  if (p.vec3("eulerAngles", {0, 0, 0}) != Vec3f{0, 0, 0}) p.fail_at("eulerAngles", "is not zero, expected no turn");
  p.ignore({"sphericalTexture"});
}

SpectrumInput read_constant(Properties& p) {
  SpectrumInput value = p.spectrum_input("value", SpectrumDescription::constant(0), SpectrumRole::kIor);
  p.ignore({"filename", "eulerAngles", "sphericalTexture"});  // properties of the image that the constant replaces
  p.reject_unused();
  return value;
}

}  // namespace

SpectrumInput texture_of(const XmlElement& element, ReadContext& context) {
  if (const SpectrumInput* known = find_read_texture(element, context)) return *known;
  const std::vector<std::string>& plain = spectrum_plugins();
  if (element.name != "texture" || std::find(plain.begin(), plain.end(), element.attribute("type")) != plain.end())
    return read_spectrum(element, context);
  Properties p(element, context);
  TextureDescription texture;
  if (p.type() == "constant_color" || p.type() == "constant_float") return read_constant(p);
  if (p.type() == "checkerboard_color" || p.type() == "checkerboard_float") {
    read_checkerboard(p, texture);
  } else if (is_picture(p.type())) {
    texture.model = read_bitmap(p);
    texture.to_uv = read_placement(p, 1);
    read_turn(p);
  } else if (!read_shared_texture(p, PictureOrigin::kLowerLeft, texture)) {
    std::vector<std::string> known = shared_texture_names();
    known.insert(known.end(), plain.begin(), plain.end());
    known.insert(known.end(), {"checkerboard_color", "checkerboard_float", "constant_color", "constant_float", "image",
                               "imagetexture", "normaltexture", "png_texture"});
    std::sort(known.begin(), known.end());
    p.fail_plugin(known);
  }
  return add_texture(p, std::move(texture));
}

}  // namespace sheaf::nori

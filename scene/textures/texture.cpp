#include "scene/textures/texture.h"

#include <cmath>

namespace sheaf {

void TextureRowBuilder::expect_finite(float value, const char* name) const {
  if (!std::isfinite(value)) throw error(fmt::format("'{}' is not finite", name));
}

void TextureRowBuilder::expect_attribute_name(const std::string& name) const {
  if (!is_attribute_name(name))
    throw error(
        fmt::format("'{}' is not a mesh attribute (expected a name that begins with 'vertex_' or 'face_')", name));
}

SpectrumInput TextureRowBuilder::as_color(const ScalarInput& input) {
  if (const float* number = std::get_if<float>(&input)) return SpectrumDescription::constant(*number);
  return std::get<TextureId>(input);
}

}  // namespace sheaf

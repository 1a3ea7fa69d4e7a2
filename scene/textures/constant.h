// One color everywhere, where only a texture will do.
#pragma once

#include "scene/description/scaled_spectrum.h"
#include "scene/textures/texture.h"

namespace sheaf {

/// Data of a constant's row.
struct ConstantRow {
  float rgb[3];  ///< linear Rec.709
  float scalar;  ///< value as a scalar
};

/// The row of a color without bounds.
ConstantRow constant_row(const SpectrumDescription& value);

/// One color everywhere.
struct ConstantTextureDescription {
  SpectrumDescription value = SpectrumDescription::constant(0.5f);

  static constexpr TextureDomain kDomain = TextureDomain::kNothing;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.value); }
  static constexpr auto colors(auto&) { return std::tie(); }
  void scale_by(float by) { value = scaled(value, by); }
  void make_row(TextureRowBuilder& row) const { row.set(constant_row(value)); }
};

}  // namespace sheaf

// Lines of a grid.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// Data of a grid's row.
struct GridTextureRow {
  float line_width;  ///< GridTextureDescription::line_width
};

/// Lines of a grid of unit squares. The color is `color1` within `line_width` of integer u or v, and `color0`
/// elsewhere.
struct GridTextureDescription {
  SpectrumInput color0 = SpectrumDescription::constant(0.2f), color1 = SpectrumDescription::constant(0.4f);
  float line_width = 0.01f;

  static constexpr TextureDomain kDomain = TextureDomain::kUv;
  static constexpr std::array kPlugins = {"gridtexture"};
  static constexpr ParameterName kParameters[] = {{"color0"}, {"color1"}, {"line_width", nullptr, kNotNegative}};
  static constexpr auto fields(auto& s) { return std::tie(s.color0, s.color1, s.line_width); }
  static constexpr auto colors(auto& s) { return std::tie(s.color0, s.color1); }
  static constexpr bool kShowsColors = true;

  void make_row(TextureRowBuilder& row) const {
    if (!(line_width >= 0)) throw row.error("'line_width' is negative or not a number");
    row.add_inputs(color0, color1);
    row.set(GridTextureRow{line_width});
  }
};

}  // namespace sheaf

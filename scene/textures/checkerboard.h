// Checkerboards.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// Alternating squares: `color0` where floor(2u) + floor(2v) is even, with the texture's transform applied.
struct CheckerboardDescription {
  SpectrumInput color0 = SpectrumDescription::constant(0.4f), color1 = SpectrumDescription::constant(0.2f);

  static constexpr TextureDomain kDomain = TextureDomain::kUv;
  static constexpr std::array kPlugins = {"checkerboard"};
  static constexpr ParameterName kParameters[] = {{"color0"}, {"color1"}};
  static constexpr auto fields(auto& s) { return std::tie(s.color0, s.color1); }
  static constexpr auto colors(auto& s) { return std::tie(s.color0, s.color1); }
  static constexpr bool kShowsColors = true;
  void make_row(TextureRowBuilder& row) const { row.add_inputs(color0, color1); }
};

}  // namespace sheaf

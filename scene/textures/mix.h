// Mixes of two textures.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// (1 - amount) color0 + amount color1. The transforms of both inputs apply; the texture's own does not.
struct MixTextureDescription {
  SpectrumInput color0 = SpectrumDescription::constant(0), color1 = SpectrumDescription::constant(1);
  ScalarInput amount = 0.5f;  ///< may lie outside [0, 1]

  static constexpr TextureDomain kDomain = TextureDomain::kNothing;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.color0, s.color1, s.amount); }
  static constexpr auto colors(auto& s) { return std::tie(s.color0, s.color1); }
  static constexpr bool kShowsColors = false;
  void make_row(TextureRowBuilder& row) const { row.add_inputs(color0, color1, amount); }
};

}  // namespace sheaf

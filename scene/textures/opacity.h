// Colors times an opacity.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// `color` times `opacity` as masks use it: as a scalar, clamped to [0, 1]. The transforms of both inputs apply; the
/// texture's own does not.
struct OpacityTextureDescription {
  SpectrumInput color = SpectrumDescription::constant(1);
  ScalarInput opacity = 1.0f;

  static constexpr TextureDomain kDomain = TextureDomain::kNothing;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.color, s.opacity); }
  static constexpr auto colors(auto& s) { return std::tie(s.color); }
  static constexpr bool kShowsColors = false;
  void make_row(TextureRowBuilder& row) const { row.add_inputs(color, opacity); }
};

}  // namespace sheaf

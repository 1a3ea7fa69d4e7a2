// Products of two textures.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// a b, channel by channel. As a scalar: the product of both as scalars. The transforms of both inputs apply; the
/// texture's own does not.
struct ProductTextureDescription {
  SpectrumInput a = SpectrumDescription::constant(1), b = SpectrumDescription::constant(1);

  static constexpr TextureDomain kDomain = TextureDomain::kNothing;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.a, s.b); }
  /// One of the factors: scaling both would scale the product twice.
  static constexpr auto colors(auto& s) { return std::tie(s.a); }
  static constexpr bool kShowsColors = false;
  void make_row(TextureRowBuilder& row) const { row.add_inputs(a, b); }
};

}  // namespace sheaf

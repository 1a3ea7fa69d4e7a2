// Textures that are 0 or 1.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// Data of a threshold's row.
struct ThresholdRow {
  float threshold, value;
};

/// `value` where the input is at least the threshold, otherwise 0: an alpha mask. The transform of the input applies;
/// the texture's own does not.
struct ThresholdTextureDescription {
  ScalarInput input = 1.0f;
  float threshold = 0.5f;
  float value = 1;

  static constexpr TextureDomain kDomain = TextureDomain::kNothing;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.input, s.threshold, s.value); }
  static constexpr auto colors(auto&) { return std::tie(); }
  void scale_by(float by) { value *= by; }

  void make_row(TextureRowBuilder& row) const {
    row.expect_finite(threshold, "threshold");
    row.expect_finite(value, "value");
    row.add_inputs(input);
    row.set(ThresholdRow{threshold, value});
  }
};

}  // namespace sheaf

// Textures that give the direction of a vector in the plane.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// Data of a direction's row.
struct DirectionRow {
  float offset, scale;
};

/// The angle of the vector (2x - 1, 2y - 1), in radians counterclockwise from the x axis, plus an offset; all that
/// times `scale`. The transforms of the inputs apply; the texture's own does not.
struct DirectionTextureDescription {
  ScalarInput x = 1.0f, y = 0.5f;  ///< components of the vector, mapped from [-1, 1] to [0, 1]
  float offset = 0;                ///< radians
  float scale = 1;

  static constexpr TextureDomain kDomain = TextureDomain::kNothing;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.x, s.y, s.offset, s.scale); }
  static constexpr auto colors(auto&) { return std::tie(); }
  void scale_by(float by) { scale *= by; }

  void make_row(TextureRowBuilder& row) const {
    row.expect_finite(offset, "offset");
    row.expect_finite(scale, "scale");
    row.add_inputs(x, y);
    row.set(DirectionRow{offset, scale});
  }
};

}  // namespace sheaf

// Volume grids as textures of surfaces.
#pragma once

#include "scene/description/grid_volume.h"
#include "scene/textures/texture.h"

namespace sheaf {

/// Data of a volume's row.
struct VolumeTextureRow {
  std::uint32_t grid;  ///< into TextureView::grids
  float scale;
};

/// A volume grid as a surface texture: evaluated at the world-space position of the surface point.
struct VolumeTextureDescription {
  GridVolumeDescription grid;
  float scale = 1;

  static constexpr TextureDomain kDomain = TextureDomain::kPoint;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.grid.file, s.grid.filter, s.grid.wrap, s.grid.raw, s.scale);
  }
  static constexpr auto colors(auto&) { return std::tie(); }
  void scale_by(float by) { scale *= by; }

  void make_row(TextureRowBuilder& row) const {
    row.expect_finite(scale, "scale");
    row.set(VolumeTextureRow{row.load_grid(grid), scale});
  }
};

}  // namespace sheaf

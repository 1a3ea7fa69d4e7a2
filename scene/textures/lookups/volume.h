// Lookups of volume grids on surfaces.
#pragma once

#include "core/soa/lane_array.h"
#include "scene/tables/brick_grid_lookup.h"
#include "scene/textures/lookups/lookup.h"
#include "scene/textures/volume.h"

namespace sheaf {

struct VolumeTexture : WithoutSlopes {
  using Description = VolumeTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    const Value<L> value = lookup<L>(at.view, at.row.template data<VolumeTextureRow>(), at.query.p);
    return {value.rgb[0], value.rgb[1], value.rgb[2], Float<L>(0.0f)};
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    const auto data = at.row.template data<VolumeTextureRow>();
    const Value<L> value = lookup<L>(at.view, data, at.query.p);
    return at.view.grids[data.grid].channels == 1 ? value.rgb[0] : texture_luminance(value.rgb);
  }

 private:
  /// In three channels, times the row's scale.
  template <class L> struct Value { typename L::Float rgb[3]; };
  /// Not inlined, to have one copy of the code: few scenes use it.
  template <class L>
  [[gnu::noinline]] static Value<L> lookup(const TextureView& view, VolumeTextureRow row, Vec3<L> p) {
    LaneRows<L, Vec3> values(p);
    for (int lane = 0; lane < L::width; ++lane)
      values.set(lane, lookup_grid_color(view.grids[row.grid], values[lane]) * row.scale);
    const Vec3<L> rgb = values.load();
    return {{rgb.x, rgb.y, rgb.z}};
  }
};

template <> struct LookupOf<VolumeTextureDescription> { using Type = VolumeTexture; };

}  // namespace sheaf

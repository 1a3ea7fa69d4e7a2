// Lookups of grids of lines.
#pragma once

#include "scene/textures/grid.h"
#include "scene/textures/lookups/lookup.h"

namespace sheaf {

struct GridTexture : WithoutSlopes {
  using Description = GridTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    return at.choose_color(is_off_lines<L>(at));
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    return at.choose_scalar(is_off_lines<L>(at));
  }

 private:
  template <class L> static SHEAF_INLINE Mask<L> is_off_lines(const TextureLookup<L>& at) {
    using F = typename L::Float;
    const Vec2<L> uv = at.uv();
    const F width(at.row.template data<GridTextureRow>().line_width);
    const F u = abs(uv.x - floor(uv.x + F(0.5f))), v = abs(uv.y - floor(uv.y + F(0.5f)));
    return (u >= width) & (v >= width);
  }
};

template <> struct LookupOf<GridTextureDescription> { using Type = GridTexture; };

}  // namespace sheaf

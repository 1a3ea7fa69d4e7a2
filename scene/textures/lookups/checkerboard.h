// Lookups of checkerboards.
#pragma once

#include "scene/textures/checkerboard.h"
#include "scene/textures/lookups/lookup.h"

namespace sheaf {

struct CheckerboardTexture : WithoutSlopes {
  using Description = CheckerboardDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    return at.choose_color(is_even<L>(at.uv()));
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    return at.choose_scalar(is_even<L>(at.uv()));
  }

 private:
  /// Whether floor(2u) + floor(2v) is even.
  template <class L> static SHEAF_INLINE Mask<L> is_even(Vec2<L> uv) {
    using F = typename L::Float;
    const Mask<L> right = uv.x - floor(uv.x) >= F(0.5f), upper = uv.y - floor(uv.y) >= F(0.5f);
    return select(right, upper, !upper);
  }
};

template <> struct LookupOf<CheckerboardDescription> { using Type = CheckerboardTexture; };

}  // namespace sheaf

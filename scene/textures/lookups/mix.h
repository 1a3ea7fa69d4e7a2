// Lookups of mixes.
#pragma once

#include "scene/textures/lookups/lookup.h"
#include "scene/textures/mix.h"

namespace sheaf {

/// Inputs 0 and 1, mixed by input 2.
struct MixTexture {
  using Description = MixTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    const Float<L> t = at.scalar(2);
    return at.color(0) * (Float<L>(1.0f) - t) + at.color(1) * t;
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    return lerp(at.scalar(2), at.scalar(0), at.scalar(1));
  }
  template <class L> static SHEAF_INLINE Vec2<L> slopes(const TextureLookup<L>& at) {
    const Vec2<L> a = at.slopes(0), b = at.slopes(1), t = at.slopes(2);
    const Float<L> amount = at.scalar(2), step = at.scalar(1) - at.scalar(0);
    return {fma(step, t.x, lerp(amount, a.x, b.x)), fma(step, t.y, lerp(amount, a.y, b.y))};
  }
};

template <> struct LookupOf<MixTextureDescription> { using Type = MixTexture; };

}  // namespace sheaf

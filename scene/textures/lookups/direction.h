// Lookups of directions.
#pragma once

#include "scene/textures/direction.h"
#include "scene/textures/lookups/lookup.h"

namespace sheaf {

struct DirectionTexture : WithoutSlopes {
  using Description = DirectionTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    const Float<L> value = scalar<L>(at);
    return {value, value, value, Float<L>(0.0f)};
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    using F = Float<L>;
    const auto data = at.row.template data<DirectionRow>();
    const F x = fma(F(2.0f), at.scalar(0), F(-1.0f)), y = fma(F(2.0f), at.scalar(1), F(-1.0f));
    return (atan2(y, x) + F(data.offset)) * F(data.scale);
  }
};

template <> struct LookupOf<DirectionTextureDescription> { using Type = DirectionTexture; };

}  // namespace sheaf

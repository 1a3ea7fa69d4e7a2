// Lookups of constants.
#pragma once

#include "scene/textures/constant.h"
#include "scene/textures/lookups/lookup.h"

namespace sheaf {

struct ConstantTexture : WithoutSlopes {
  using Description = ConstantTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    using F = typename L::Float;
    const auto data = at.row.template data<ConstantRow>();
    return {F(data.rgb[0]), F(data.rgb[1]), F(data.rgb[2]), F(0.0f)};
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    return Float<L>(at.row.template data<ConstantRow>().scalar);
  }
};

template <> struct LookupOf<ConstantTextureDescription> { using Type = ConstantTexture; };

}  // namespace sheaf

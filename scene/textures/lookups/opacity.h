// Lookups of colors times an opacity.
#pragma once

#include "scene/textures/lookups/lookup.h"
#include "scene/textures/opacity.h"

namespace sheaf {

/// Input 0 times input 1, a scalar that is clamped to [0, 1].
struct OpacityTexture : WithoutSlopes {
  using Description = OpacityTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    return at.color(0) * opacity<L>(at);
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    return at.scalar(0) * opacity<L>(at);
  }

 private:
  template <class L> static SHEAF_INLINE Float<L> opacity(const TextureLookup<L>& at) {
    return clamp(at.scalar(1), Float<L>(0.0f), Float<L>(1.0f));
  }
};

template <> struct LookupOf<OpacityTextureDescription> { using Type = OpacityTexture; };

}  // namespace sheaf

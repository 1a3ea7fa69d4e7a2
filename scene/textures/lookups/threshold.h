// Lookups of thresholds.
#pragma once

#include "scene/textures/lookups/lookup.h"
#include "scene/textures/threshold.h"

namespace sheaf {

struct ThresholdTexture : WithoutSlopes {
  using Description = ThresholdTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    const Float<L> value = scalar<L>(at);
    return {value, value, value, Float<L>(0.0f)};
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    using F = Float<L>;
    const auto data = at.row.template data<ThresholdRow>();
    return select(at.scalar(0) >= F(data.threshold), F(data.value), F(0.0f));
  }
};

template <> struct LookupOf<ThresholdTextureDescription> { using Type = ThresholdTexture; };

}  // namespace sheaf

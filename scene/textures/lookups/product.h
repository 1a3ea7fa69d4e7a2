// Lookups of products.
#pragma once

#include "scene/textures/lookups/lookup.h"
#include "scene/textures/product.h"

namespace sheaf {

/// Input 0 times input 1.
struct ProductTexture {
  using Description = ProductTextureDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    return at.color(0) * at.color(1);
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    return at.scalar(0) * at.scalar(1);
  }
  /// The product rule.
  template <class L> static SHEAF_INLINE Vec2<L> slopes(const TextureLookup<L>& at) {
    const Vec2<L> a = at.slopes(0), b = at.slopes(1);
    const Float<L> first = at.scalar(0), second = at.scalar(1);
    return {fma(first, b.x, second * a.x), fma(first, b.y, second * a.y)};
  }
};

template <> struct LookupOf<ProductTextureDescription> { using Type = ProductTexture; };

}  // namespace sheaf

// Lookups of wireframes.
#pragma once

#include "scene/textures/lookups/mesh_attribute.h"
#include "scene/textures/wireframe.h"

namespace sheaf {

/// Input 0 is the interior, input 1 the edge.
struct WireframeTexture : WithoutSlopes {
  using Description = WireframeDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    const Float<L> interior = interior_weight<L>(at);
    const Spectrum<L> first = at.color(0), second = at.color(1);
    return {lerp(interior, second.c0, first.c0), lerp(interior, second.c1, first.c1),
            lerp(interior, second.c2, first.c2), Float<L>(0.0f)};
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    return lerp(interior_weight<L>(at), at.scalar(1), at.scalar(0));
  }

 private:
  /// Weight of the interior; 1 on shapes without triangles.
  template <class L> static SHEAF_INLINE Float<L> interior_weight(const TextureLookup<L>& at) {
    using F = typename L::Float;
    const auto data = at.row.template data<WireframeRow>();
    const TextureQuery<L>& query = at.query;
    const AttributeValue<L> corner = lookup_attribute<L>(at.view, data.attribute, 1.0f, query);
    const F b0 = F(1.0f) - query.b1 - query.b2;
    const F distance = min(b0 * corner.rgb[0], min(query.b1 * corner.rgb[1], query.b2 * corner.rgb[2]));
    const float width = data.outer - data.inner;
    const F step = select(distance < F(data.outer), F(0.0f), F(1.0f));
    const F t = width > 0.0f ? clamp((distance - F(data.inner)) * F(1.0f / width), F(0.0f), F(1.0f)) : step;
    return select(corner.colored, t * t * (F(3.0f) - F(2.0f) * t), F(1.0f));
  }
};

template <> struct LookupOf<WireframeDescription> { using Type = WireframeTexture; };

}  // namespace sheaf

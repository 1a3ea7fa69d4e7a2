// Lookups at other texture coordinates.
#pragma once

#include "scene/textures/lookups/mesh_attribute.h"
#include "scene/textures/uv_set.h"

namespace sheaf {

/// Input 0 at the coordinates in the attribute.
struct UvSetTexture : WithoutSlopes {
  using Description = UvSetTextureDescription;
  static constexpr bool kMovesInputs = true;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    const TextureQuery<L> query = moved<L>(at);
    return TextureLookup<L>{at.view, at.row, query}.color(0);
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    const TextureQuery<L> query = moved<L>(at);
    return TextureLookup<L>{at.view, at.row, query}.scalar(0);
  }

 private:
  template <class L> static SHEAF_INLINE TextureQuery<L> moved(const TextureLookup<L>& at) {
    const auto data = at.row.template data<UvSetRow>();
    const AttributeValue<L> uv = lookup_attribute<L>(at.view, data.attribute, 1.0f, at.query);
    TextureQuery<L> query = at.query;
    query.uv = {uv.rgb[0], uv.rgb[1]};
    query.footprint = query.footprint_axis = {Float<L>(0.0f), Float<L>(0.0f)};
    return query;
  }
};

template <> struct LookupOf<UvSetTextureDescription> { using Type = UvSetTexture; };

}  // namespace sheaf

// Lookups of mesh attributes.
#pragma once

#include "scene/textures/lookups/lookup.h"
#include "scene/textures/mesh_attribute.h"

namespace sheaf {

/// A mesh attribute in three channels. `colored` if it has three channels.
template <class L> struct AttributeValue {
  typename L::Float rgb[3];
  typename L::Mask colored;
};

/// An attribute of TextureTables::attribute_names, times `scale`. Zero if the shape lacks it.
template <class L>
SHEAF_INLINE AttributeValue<L> lookup_attribute(const TextureView& view, std::uint32_t attribute, float scale,
                                                const TextureQuery<L>& query) {
  using F = typename L::Float;
  using U = typename L::Uint;
  AttributeValue<L> out{{F(0.0f), F(0.0f), F(0.0f)}, typename L::Mask(false)};
  if (view.shape_count == 0) return out;
  const U shape = min(query.shape, U(view.shape_count - 1));
  const AttributeRecord<L> entry = gather_rows<L>(view.attributes, U(attribute * view.shape_count) + shape);
  const U channels = entry.layout & U(AttributeEntry::kChannels), zero(0u);
  const auto present = channels != zero, per_face = (entry.layout & U(AttributeEntry::kPerFace)) != zero;
  if (!any(present)) return out;
  out.colored = channels == U(3u);

  const U primitive = select(present, min(query.primitive, entry.triangle_count - U(1u)), zero);
  const auto corners = gather_triple<L>(view.triangles, select(present, entry.first_triangle + primitive, zero));
  const F weights[3] = {select(per_face, F(1.0f), F(1.0f) - query.b1 - query.b2), select(per_face, F(0.0f), query.b1),
                        select(per_face, F(0.0f), query.b2)};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const U element = select(per_face, primitive, corners[corner]);
    F value[4];
    gather_row4<L>(view.attribute_values, select(present, entry.first_value + element * channels, zero), value);
    for (int k = 0; k < 3; ++k) {
      const F channel = select(out.colored, value[k], value[0]);
      out.rgb[k] = fma(weights[corner], channel, out.rgb[k]);
    }
  }
  for (F& channel : out.rgb) channel = select(present, channel * F(scale), F(0.0f));
  return out;
}

struct MeshAttributeTexture : WithoutSlopes {
  using Description = MeshAttributeDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    const AttributeValue<L> value = lookup<L>(at);
    return {value.rgb[0], value.rgb[1], value.rgb[2], Float<L>(0.0f)};
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    const AttributeValue<L> value = lookup<L>(at);
    return select(value.colored, texture_luminance(value.rgb), value.rgb[0]);
  }

 private:
  template <class L> static SHEAF_INLINE AttributeValue<L> lookup(const TextureLookup<L>& at) {
    const auto data = at.row.template data<MeshAttributeRow>();
    return lookup_attribute<L>(at.view, data.attribute, data.scale, at.query);
  }
};

template <> struct LookupOf<MeshAttributeDescription> { using Type = MeshAttributeTexture; };

}  // namespace sheaf

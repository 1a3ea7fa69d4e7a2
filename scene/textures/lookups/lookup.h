// The interface of the lookups of a kind of textures.
//
// The lookups of a kind are a struct of static functions, generic in the lane policy. It names its description
// (Description, one of scene/textures/list.h) and defines
//     color     the texture's color: linear Rec.709 with 0 in the fourth lane; scalars are gray,
//     scalar    the texture as a scalar: the luminance of colors,
//     slopes    derivatives of `scalar` by the surface's u and v; kinds that have none derive from WithoutSlopes,
// and optionally
//     prefetch      prefetches what a color lookup will read, besides that of its inputs,
//     kMovesInputs  true: inputs are looked up at other coordinates and are not prefetched.
// A specialization of LookupOf below the struct makes them the lookups of its description.
//
// All lanes look up the same texture. Any coordinates are safe, including NaN: lookups stay inside their table.
#pragma once

#include "scene/textures/texture_lookup.h"

#include <concepts>

namespace sheaf {

/// `Type` has the lookups of a description of scene/textures/list.h. Each kind specializes it beside its lookups.
template <class Description> struct LookupOf;

/// Applies a texture's transform.
template <class L> SHEAF_INLINE Vec2<L> texture_uv(const TextureRow& row, Vec2<L> uv) {
  using F = typename L::Float;
  const float* m = row.to_uv;
  return {fma(F(m[0]), uv.x, fma(F(m[1]), uv.y, F(m[2]))), fma(F(m[3]), uv.x, fma(F(m[4]), uv.y, F(m[5])))};
}

/// Rec.709 luminance.
template <class F> SHEAF_INLINE F texture_luminance(const F* rgb) {
  return fma(rgb[0], F(0.2126390f), fma(rgb[1], F(0.7151687f), rgb[2] * F(0.0721923f)));
}

/// One lookup: a row, and the points.
template <class L> struct TextureLookup {
  using F = typename L::Float;

  const TextureView& view;
  const TextureRow& row;
  const TextureQuery<L>& query;

  /// uv with the texture's transform applied.
  SHEAF_INLINE Vec2<L> uv() const { return texture_uv<L>(row, query.uv); }

  // Lookups of input k.
  SHEAF_INLINE Spectrum<L> color(std::size_t k) const { return lookup_texture<L>(view, row.inputs[k], query); }
  SHEAF_INLINE F scalar(std::size_t k) const { return lookup_scalar<L>(view, row.inputs[k], query); }
  SHEAF_INLINE Vec2<L> slopes(std::size_t k) const { return lookup_scalar_gradient<L>(view, row.inputs[k], query); }

  // Input 0 in the lanes of `first`, input 1 in the others.
  SHEAF_INLINE Spectrum<L> choose_color(const Mask<L>& first) const {
    if (all(first)) return color(0);
    if (!any(first)) return color(1);
    return select<L>(first, color(0), color(1));
  }
  SHEAF_INLINE F choose_scalar(const Mask<L>& first) const {
    if (all(first)) return scalar(0);
    if (!any(first)) return scalar(1);
    return select(first, scalar(0), scalar(1));
  }
};

/// Base of kinds without slopes.
struct WithoutSlopes {
  template <class L> static SHEAF_INLINE Vec2<L> slopes(const TextureLookup<L>&) {
    return {typename L::Float(0.0f), typename L::Float(0.0f)};
  }
};

/// The requirements on the lookups of a kind.
template <class Texture>
concept TextureLookups = requires(const TextureLookup<Scalar>& at) {
  typename Texture::Description;
  { Texture::template color<Scalar>(at) } -> std::same_as<Spectrum4>;
  { Texture::template scalar<Scalar>(at) } -> std::same_as<float>;
  { Texture::template slopes<Scalar>(at) } -> std::same_as<Vec2<Scalar>>;
};

}  // namespace sheaf

// Looking up textures, generic in the lane. All lanes look up the same texture, each at its own place.
//
// Texel (x, y) of a picture of w x h, counted from the lower left, lies at uv ((x + 1/2) / w, (y + 1/2) / h). Bilinear
// lookups mix the four texels around; bytes are decoded first. Coordinates may be anything, NaN included: no lookup
// leaves its table, and what is no number counts as 0.
#pragma once

#include "scene/tables/shape.h"
#include "scene/tables/texture.h"

#include <iterator>

namespace sheaf {

/// Where textures are looked up.
template <class L> struct TextureQuery {
  Vec2<L> uv;                  ///< of the surface
  typename L::Uint shape;      ///< mesh attributes, wireframes: index below TextureView::shape_count
  typename L::Uint primitive;  ///< mesh attributes: triangle of the shape; others than it has become its last
  typename L::Float b1, b2;    ///< mesh attributes: barycentric coordinates, the weights of vertices 1 and 2
  Vec3<L> p{};                 ///< volumes: world space; lights, which no volumes colour, leave it out
};

/// The sRGB curve (IEC 61966-2-1), encoded to linear, of a whole number from 0 to 255: increasing, 0 to 0 and 255 to 1
/// exactly, off by at most 6e-6. Above the curve's linear part a polynomial of degree 6 takes the power's place, the
/// one with the smallest largest error over the bytes there that is 1 at 255.
template <class F> SHEAF_INLINE F decode_srgb_byte(F byte) {
  constexpr float kCoefficients[] = {-1.91261509e-16f, 2.04817337e-13f, -1.01286438e-10f, 4.30494325e-8f,
                                     7.87728004e-6f,   1.29644643e-4f,  9.17128404e-4f};
  F curve(kCoefficients[0]);
  for (std::size_t k = 1; k < std::size(kCoefficients); ++k) curve = fma(curve, byte, F(kCoefficients[k]));
  return select(byte < F(10.5f), byte * F(1.0f / (255.0f * 12.92f)), curve);
}

// Compiled once for Wide and Scalar: many stages look up textures, and each would hold a copy.

/// The texture's colour: linear Rec.709 and 0 in the fourth lane. Numbers are grey. `texture` is a row of `view`.
template <class L>
Spectrum<L> lookup_texture(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// The texture as a number: of colours the luminance.
template <class L>
Float<L> lookup_scalar(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// How lookup_scalar() changes with the surface's u and v: the slope of the bilinear patch, the texture's transform
/// included. Zero for textures that are neither bilinear pictures nor mixes of such.
template <class L>
Vec2<L> lookup_scalar_gradient(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// Starts to fetch the texels that a lookup at `uv` will read; of other textures than pictures and what is made of
/// them, nothing.
template <class L> void prefetch_texture(const TextureView& view, std::uint32_t texture, Vec2<L> uv) noexcept;

/// What a binding's texture puts into the closure's words: binding.words of the result's lanes, from the first on.
template <class L>
SHEAF_INLINE Spectrum<L> lookup_binding(const TextureView& view, const TextureBinding& binding,
                                        const TextureQuery<L>& query) {
  using F = typename L::Float;
  const bool burley = binding.role == TextureRole::kBurleyLuminance;
  if (binding.words == 1 && !burley) return {lookup_scalar<L>(view, binding.texture, query), F(0.0f), F(0.0f), F(0.0f)};
  const Spectrum<L> value = lookup_texture<L>(view, binding.texture, query);
  if (burley) return {value.c0 * F(0.3f) + value.c1 * F(0.6f) + value.c2 * F(0.1f), F(0.0f), F(0.0f), F(0.0f)};
  if (binding.role != TextureRole::kReflectance) return value;
  const F zero(0.0f), one(1.0f);
  return {clamp(value.c0, zero, one), clamp(value.c1, zero, one), clamp(value.c2, zero, one), value.c3};
}

}  // namespace sheaf

// Texture lookups, generic in the lane policy. All lanes look up the same texture, each at its own point.
//
// Texel (x, y) of a w x h image, counted from the lower left, lies at uv ((x + 1/2) / w, (y + 1/2) / h). Bilinear
// lookups interpolate the four nearest texels after decoding. Any coordinates are safe, including NaN: lookups stay
// inside their table, and NaN counts as 0.
#pragma once

#include "scene/tables/shape.h"
#include "scene/tables/texture.h"

#include <iterator>

namespace sheaf {

/// The point at which textures are looked up.
template <class L> struct TextureQuery {
  Vec2<L> uv;              ///< of the surface
  typename L::Uint shape;  ///< mesh attributes, wireframes: index below TextureView::shape_count
  /// Mesh attributes: triangle of the shape; indices out of range are clamped to the last triangle.
  typename L::Uint primitive;
  typename L::Float b1, b2;  ///< mesh attributes: barycentric coordinates, the weights of vertices 1 and 2
  Vec3<L> p{};               ///< volumes: world-space point; not set by lights, whose textures contain no volumes
  static constexpr auto fields(auto& s) { return std::tie(s.uv, s.shape, s.primitive, s.b1, s.b2, s.p); }
};

/// Decodes sRGB (IEC 61966-2-1) to linear for an integer from 0 to 255. Monotonic, with 0 to 0 and 255 to 1 exactly;
/// maximum error 6e-6. Above the linear part of the curve it uses the minimax polynomial of degree 6 over the bytes
/// there that is 1 at 255.
template <class F> SHEAF_INLINE F decode_srgb_byte(F byte) {
  constexpr float kCoefficients[] = {-1.91261509e-16f, 2.04817337e-13f, -1.01286438e-10f, 4.30494325e-8f,
                                     7.87728004e-6f,   1.29644643e-4f,  9.17128404e-4f};
  F curve(kCoefficients[0]);
  for (std::size_t k = 1; k < std::size(kCoefficients); ++k) curve = fma(curve, byte, F(kCoefficients[k]));
  return select(byte < F(10.5f), byte * F(1.0f / (255.0f * 12.92f)), curve);
}

// Compiled once for Wide and Scalar, because many stages use them and each would contain a copy.

/// The texture's colour: linear Rec.709 with 0 in the fourth lane. Scalars are grey. `texture` is a row of `view`.
template <class L>
Spectrum<L> lookup_texture(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// The texture as a scalar: the luminance of colours.
template <class L>
Float<L> lookup_scalar(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// Derivatives of lookup_scalar() by the surface's u and v: the slope of the bilinear patch, with the texture's
/// transform applied. Zero except for bilinear images and mixes of these.
template <class L>
Vec2<L> lookup_scalar_gradient(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// Prefetches the texels that a lookup at `uv` will read. Only acts on images and textures composed of them.
template <class L> void prefetch_texture(const TextureView& view, std::uint32_t texture, Vec2<L> uv) noexcept;

/// Values of a binding's texture for the closure's words: the first binding.words lanes of the result.
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

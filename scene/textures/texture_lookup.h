// Texture lookups, generic in the lane policy. All lanes look up the same texture, each at its own point. Any
// coordinates are safe, including NaN. scene/textures/lookups/ implements them for each kind of textures.
#pragma once

#include "scene/surfaces/shape.h"
#include "scene/tables/texture.h"

namespace sheaf {

/// The point at which textures are looked up.
template <class L> struct TextureQuery {
  Vec2<L> uv;              ///< of the surface
  typename L::Uint shape;  ///< mesh attributes, wireframes: index below TextureView::shape_count
  /// Mesh attributes: triangle of the shape; indices out of range are clamped to the last triangle.
  typename L::Uint primitive;
  typename L::Float b1, b2;  ///< mesh attributes: barycentric coordinates, the weights of vertices 1 and 2
  Vec3<L> p{};               ///< volumes: world-space point; not set by lights, whose textures contain no volumes
  /// Squared lengths along u and v of the part of the surface over which colors are averaged; 0: the point alone.
  Vec2<L> footprint{typename L::Float(0.0f), typename L::Float(0.0f)};
  /// That part is moved along this vector of the uv plane, from minus to plus one half of it.
  Vec2<L> footprint_axis{typename L::Float(0.0f), typename L::Float(0.0f)};
  static constexpr auto fields(auto& s) {
    return std::tie(s.uv, s.shape, s.primitive, s.b1, s.b2, s.p, s.footprint, s.footprint_axis);
  }
};

// Compiled once for Wide and Scalar, because many stages use them and each would contain a copy.

/// The texture's color: linear Rec.709 with 0 in the fourth lane. Scalars are gray. `texture` is a row of `view`.
/// Images with mip levels are looked up in that whose texels fit the footprint, at several points along its axis.
template <class L>
Spectrum<L> lookup_texture(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// The texture as a scalar: the luminance of colors. Ignores the footprint, as opacities and weights are not linear.
template <class L>
Float<L> lookup_scalar(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// Derivatives of lookup_scalar() by the surface's u and v, with the texture's transform applied. Zero except for
/// bilinear images, and mixes and products of these.
template <class L>
Vec2<L> lookup_scalar_gradient(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

/// Prefetches the texels that a color lookup at `uv` with `footprint` will read. Only acts on images and textures
/// composed of them at the same coordinates.
template <class L>
void prefetch_texture(const TextureView& view, std::uint32_t texture, Vec2<L> uv, Vec2<L> footprint) noexcept;

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

#include "scene/textures/texture_lookup.h"

#include "scene/textures/lookups/list.h"

namespace sheaf {

template <class L>
void prefetch_texture(const TextureView& view, std::uint32_t texture, Vec2<L> uv, Vec2<L> footprint) noexcept {
  const TextureRow& row = view.rows[texture];
  bool moves_inputs = false;
  Textures::with(row.kind, [&]<class Texture>() SHEAF_LAMBDA_INLINE {
    if constexpr (requires { Texture::kMovesInputs; }) moves_inputs = Texture::kMovesInputs;
    if constexpr (requires { Texture::template prefetch<L>(view, row, uv, footprint); })
      Texture::template prefetch<L>(view, row, uv, footprint);
  });
  if (moves_inputs) return;
  for (const std::uint32_t input : row.used_inputs()) prefetch_texture<L>(view, input, uv, footprint);
}

template <class L>
Spectrum<L> lookup_texture(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept {
  const TextureLookup<L> at{view, view.rows[texture], query};
  return Textures::with(at.row.kind,
                        [&]<class Texture>() SHEAF_LAMBDA_INLINE { return Texture::template color<L>(at); });
}

template <class L>
Float<L> lookup_scalar(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept {
  const TextureLookup<L> at{view, view.rows[texture], query};
  return Textures::with(at.row.kind,
                        [&]<class Texture>() SHEAF_LAMBDA_INLINE { return Texture::template scalar<L>(at); });
}

template <class L>
Vec2<L> lookup_scalar_gradient(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept {
  const TextureLookup<L> at{view, view.rows[texture], query};
  return Textures::with(at.row.kind,
                        [&]<class Texture>() SHEAF_LAMBDA_INLINE { return Texture::template slopes<L>(at); });
}

template void prefetch_texture(const TextureView&, std::uint32_t, Vec2<Wide>, Vec2<Wide>) noexcept;
template void prefetch_texture(const TextureView&, std::uint32_t, Vec2<Scalar>, Vec2<Scalar>) noexcept;
template Spectrum<Wide> lookup_texture(const TextureView&, std::uint32_t, const TextureQuery<Wide>&) noexcept;
template Float<Wide> lookup_scalar(const TextureView&, std::uint32_t, const TextureQuery<Wide>&) noexcept;
template Vec2<Wide> lookup_scalar_gradient(const TextureView&, std::uint32_t, const TextureQuery<Wide>&) noexcept;
template Spectrum<Scalar> lookup_texture(const TextureView&, std::uint32_t, const TextureQuery<Scalar>&) noexcept;
template Float<Scalar> lookup_scalar(const TextureView&, std::uint32_t, const TextureQuery<Scalar>&) noexcept;
template Vec2<Scalar> lookup_scalar_gradient(const TextureView&, std::uint32_t, const TextureQuery<Scalar>&) noexcept;

}  // namespace sheaf

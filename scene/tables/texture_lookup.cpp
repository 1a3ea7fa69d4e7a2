#include "scene/tables/texture_lookup.h"

#include "core/prefetch.h"
#include "scene/tables/brick_grid_lookup.h"

#include <type_traits>

namespace sheaf {

/// Rec.709 luminance.
template <class F> SHEAF_INLINE F texture_luminance(const F* rgb) {
  return fma(rgb[0], F(0.2126390f), fma(rgb[1], F(0.7151687f), rgb[2] * F(0.0721923f)));
}

namespace detail {

/// Two neighbouring texels along one axis, and the interpolation weight of the second.
template <class L> struct TexelPair {
  typename L::Uint first, second;
  typename L::Float t;
};

/// Maps a coordinate to [0, 1) if repeated or to [0, 2) if mirrored; otherwise clamps it to [0, 1].
template <class F> SHEAF_INLINE F wrap_coordinate(TextureWrap wrap, F u) {
  if (wrap == TextureWrap::kClamp) return select(u > F(0.0f), min(u, F(1.0f)), F(0.0f));
  const bool mirror = wrap == TextureWrap::kMirror;
  const F s = mirror ? u * F(0.5f) : u;
  const F fraction = s - floor(s);
  const F inside = select(fraction < F(1.0f), fraction, F(0.0f));
  return mirror ? inside + inside : inside;
}

/// The texel in [0, size) for an integer coordinate i >= 0, below 2 size if mirrored and up to size otherwise.
template <class U> SHEAF_INLINE U wrap_texel(TextureWrap wrap, U i, U size) {
  const U last = size - U(1u);
  if (wrap == TextureWrap::kMirror) i = select(i < size, i, size + last - i);
  return min(i, last);
}

/// The texel that contains `u`.
template <class L>
SHEAF_INLINE typename L::Uint nearest_texel(TextureWrap wrap, typename L::Float u, std::uint32_t size) {
  const auto x = wrap_coordinate(wrap, u) * typename L::Float(static_cast<float>(size));
  return wrap_texel(wrap, to_uint(x), typename L::Uint(size));
}

/// The texels with the nearest centres on both sides of `u`.
template <class L> SHEAF_INLINE TexelPair<L> texel_pair(TextureWrap wrap, typename L::Float u, std::uint32_t size) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const F x = fma(wrap_coordinate(wrap, u), F(static_cast<float>(size)), F(0.5f));
  const F above = floor(x);
  const U second = to_uint(above), one(1u), n(size);  // from 0 to size, or to 2 size if mirrored
  const F t = x - above;
  if (wrap == TextureWrap::kRepeat) {
    const U first = min(second - one, n - one);
    return {first, select(first + one == n, U(0u), first + one), t};
  }
  const U zero(0u), first = select(second == zero, zero, second - one);
  if (wrap == TextureWrap::kClamp) return {first, min(second, n - one), t};
  return {wrap_texel(wrap, first, n), wrap_texel(wrap, select(second == n + n, zero, second), n), t};
}

/// Contributions of the column and the row to a texel's index.
template <TexelFormat Format, class U> SHEAF_INLINE U column_index(U x) {
  constexpr int kShift = tile_shift(Format);
  return ((x >> kShift) << (2 * kShift)) + (x & U((1u << kShift) - 1));
}
template <TexelFormat Format, class U> SHEAF_INLINE U row_index(U y, std::uint32_t tiles_per_row) {
  constexpr int kShift = tile_shift(Format);
  return (((y >> kShift) * U(tiles_per_row)) << (2 * kShift)) + ((y & U((1u << kShift) - 1)) << kShift);
}

/// Converts a byte to its linear value.
template <TexelFormat Format, class U> SHEAF_INLINE auto decode_byte(U byte) {
  const auto value = to_float(byte);
  if constexpr (Format == TexelFormat::kSrgbByte1 || Format == TexelFormat::kSrgbByte4)
    return decode_srgb_byte(value);
  else
    return value * decltype(value)(1.0f / 255.0f);
}

/// A texel in its storage format.
template <class L, TexelFormat Format> struct StoredTexel {
  static constexpr bool kBytes = holds_bytes(Format);
  std::conditional_t<kBytes, typename L::Uint, typename L::Float> value[kBytes ? 1 : texel_channels(Format)];

  static SHEAF_INLINE StoredTexel load(const TexelTile* tiles, typename L::Uint index) {
    const std::uint8_t* bytes = tiles->bytes;
    StoredTexel out;
    if constexpr (Format == TexelFormat::kFloat1) {
      out.value[0] = gather(reinterpret_cast<const float*>(bytes), index);
    } else if constexpr (Format == TexelFormat::kFloat4) {
      typename L::Float row[4];
      gather_row4<L>(reinterpret_cast<const float*>(bytes), index << 2, row);
      for (int k = 0; k < 3; ++k) out.value[k] = row[k];
    } else if constexpr (texel_channels(Format) == 1) {
      out.value[0] = gather_bytes(bytes, index);
    } else {
      out.value[0] = gather(reinterpret_cast<const std::uint32_t*>(bytes), index);
    }
    return out;
  }

  /// The linear value of one channel.
  template <int Channel> SHEAF_INLINE typename L::Float channel() const {
    if constexpr (!kBytes)
      return value[Channel];
    else if constexpr (texel_channels(Format) == 1)
      return decode_byte<Format>(value[0]);
    else if constexpr (Channel == 2)
      return decode_byte<Format>(value[0] >> 16);
    else
      return decode_byte<Format>((value[0] >> (8 * Channel)) & typename L::Uint(0xffu));
  }
};

/// Calls f.operator()<k>() for every channel k of the format.
template <TexelFormat Format, class F> SHEAF_INLINE void for_each_channel(F&& f) {
  f.template operator()<0>();
  if constexpr (texel_channels(Format) == 3) {
    f.template operator()<1>();
    f.template operator()<2>();
  }
}

/// The four texels around a point: lower left, lower right, upper left, upper right.
template <class L, TexelFormat Format> struct Patch {
  StoredTexel<L, Format> corner[4];
  typename L::Float tx, ty;
};

template <class L, TexelFormat Format>
SHEAF_INLINE Patch<L, Format> load_patch(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv) {
  const TexelPair<L> x = texel_pair<L>(bitmap.wrap_u, uv.x, bitmap.width);
  const TexelPair<L> y = texel_pair<L>(bitmap.wrap_v, uv.y, bitmap.height);
  const auto x0 = column_index<Format>(x.first), x1 = column_index<Format>(x.second);
  const auto y0 = row_index<Format>(y.first, bitmap.tiles_per_row),
             y1 = row_index<Format>(y.second, bitmap.tiles_per_row);
  const TexelTile* tiles = view.tiles + bitmap.first_tile;
  using Texel = StoredTexel<L, Format>;
  return {{Texel::load(tiles, y0 + x0), Texel::load(tiles, y0 + x1), Texel::load(tiles, y1 + x0),
           Texel::load(tiles, y1 + x1)},
          x.t,
          y.t};
}

/// Value of an image, in one or three channels.
template <class L, TexelFormat Format>
SHEAF_INLINE void lookup_bitmap(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv, typename L::Float* out) {
  if (bitmap.filter == TextureFilter::kNearest) {
    const auto x = nearest_texel<L>(bitmap.wrap_u, uv.x, bitmap.width);
    const auto y = nearest_texel<L>(bitmap.wrap_v, uv.y, bitmap.height);
    const auto index = row_index<Format>(y, bitmap.tiles_per_row) + column_index<Format>(x);
    const auto texel = StoredTexel<L, Format>::load(view.tiles + bitmap.first_tile, index);
    for_each_channel<Format>([&]<int K>() SHEAF_LAMBDA_INLINE { out[K] = texel.template channel<K>(); });
    return;
  }
  const auto patch = load_patch<L, Format>(view, bitmap, uv);
  for_each_channel<Format>([&]<int K>() SHEAF_LAMBDA_INLINE {
    const auto value = [&](int corner) SHEAF_LAMBDA_INLINE { return patch.corner[corner].template channel<K>(); };
    out[K] = lerp(patch.ty, lerp(patch.tx, value(0), value(1)), lerp(patch.tx, value(2), value(3)));
  });
}

/// Derivatives of an image along its axes, per texel; of the luminance for colours.
template <class L, TexelFormat Format>
SHEAF_INLINE Vec2<L> bitmap_slopes(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv) {
  const auto patch = load_patch<L, Format>(view, bitmap, uv);
  typename L::Float corner[4];
  for (int i = 0; i < 4; ++i) {
    typename L::Float value[3];
    for_each_channel<Format>([&]<int K>() SHEAF_LAMBDA_INLINE { value[K] = patch.corner[i].template channel<K>(); });
    if constexpr (texel_channels(Format) == 1)
      corner[i] = value[0];
    else
      corner[i] = texture_luminance(value);
  }
  return {lerp(patch.ty, corner[1] - corner[0], corner[3] - corner[2]),
          lerp(patch.tx, corner[2] - corner[0], corner[3] - corner[1])};
}

/// Prefetches the tiles of two opposite corners of the patch, which nearly always cover it.
template <class L, TexelFormat Format>
SHEAF_INLINE void prefetch_patch(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv) {
  const TexelPair<L> x = texel_pair<L>(bitmap.wrap_u, uv.x, bitmap.width);
  const TexelPair<L> y = texel_pair<L>(bitmap.wrap_v, uv.y, bitmap.height);
  constexpr int kShift = tile_shift(Format);
  const typename L::Uint per_row(bitmap.tiles_per_row);
  alignas(kSimdAlignment) std::uint32_t tiles[2][L::width];
  store(tiles[0], (y.first >> kShift) * per_row + (x.first >> kShift));
  store(tiles[1], (y.second >> kShift) * per_row + (x.second >> kShift));
  const TexelTile* const first = view.tiles + bitmap.first_tile;
  for (int lane = 0; lane < L::width; ++lane) {
    prefetch(first + tiles[0][lane]);
    prefetch(first + tiles[1][lane]);
  }
}

/// Calls f with the format as a template argument.
template <class F> SHEAF_INLINE auto with_format(TexelFormat format, F&& f) {
  switch (format) {
    case TexelFormat::kByte1:
      return f.template operator()<TexelFormat::kByte1>();
    case TexelFormat::kByte4:
      return f.template operator()<TexelFormat::kByte4>();
    case TexelFormat::kSrgbByte1:
      return f.template operator()<TexelFormat::kSrgbByte1>();
    case TexelFormat::kSrgbByte4:
      return f.template operator()<TexelFormat::kSrgbByte4>();
    case TexelFormat::kFloat1:
      return f.template operator()<TexelFormat::kFloat1>();
    default:
      return f.template operator()<TexelFormat::kFloat4>();
  }
}

template <class L> SHEAF_INLINE Vec2<L> texture_uv(const TextureRow& row, Vec2<L> uv) {
  using F = typename L::Float;
  const float* m = row.to_uv;
  return {fma(F(m[0]), uv.x, fma(F(m[1]), uv.y, F(m[2]))), fma(F(m[3]), uv.x, fma(F(m[4]), uv.y, F(m[5])))};
}

/// Whether the first child shows: on a checkerboard where floor(2u) + floor(2v) is even, on a grid off its lines.
template <class L> SHEAF_INLINE Mask<L> first_square(const TextureRow& row, Vec2<L> uv) {
  using F = typename L::Float;
  if (row.kind == TextureKind::kGrid) {
    const F width(row.checkerboard.line_width);
    const F u = abs(uv.x - floor(uv.x + F(0.5f))), v = abs(uv.y - floor(uv.y + F(0.5f)));
    return (u >= width) & (v >= width);
  }
  const Mask<L> right = uv.x - floor(uv.x) >= F(0.5f), upper = uv.y - floor(uv.y) >= F(0.5f);
  return select(right, upper, !upper);
}

/// A mesh attribute in three channels, times the row's scale. `coloured` if it has three channels. Zero if the shape
/// lacks it.
template <class L> struct AttributeValue {
  typename L::Float rgb[3];
  typename L::Mask coloured;
};
template <class L>
SHEAF_INLINE AttributeValue<L> lookup_attribute(const TextureView& view, const MeshAttributeRow& row,
                                                const TextureQuery<L>& query) {
  using F = typename L::Float;
  using U = typename L::Uint;
  AttributeValue<L> out{{F(0.0f), F(0.0f), F(0.0f)}, typename L::Mask(false)};
  if (view.shape_count == 0) return out;
  const U shape = min(query.shape, U(view.shape_count - 1));
  const AttributeRecord<L> entry = gather_rows<L>(view.attributes, U(row.first_entry) + shape);
  const U channels = entry.layout & U(AttributeEntry::kChannels), zero(0u);
  const auto present = channels != zero, per_face = (entry.layout & U(AttributeEntry::kPerFace)) != zero;
  if (!any(present)) return out;
  out.coloured = channels == U(3u);

  const U primitive = select(present, min(query.primitive, entry.triangle_count - U(1u)), zero);
  const auto corners = gather_triple<L>(view.triangles, select(present, entry.first_triangle + primitive, zero));
  const F weights[3] = {select(per_face, F(1.0f), F(1.0f) - query.b1 - query.b2), select(per_face, F(0.0f), query.b1),
                        select(per_face, F(0.0f), query.b2)};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const U element = select(per_face, primitive, corners[corner]);
    F value[4];
    gather_row4<L>(view.attribute_values, select(present, entry.first_value + element * channels, zero), value);
    for (int k = 0; k < 3; ++k) {
      const F channel = select(out.coloured, value[k], value[0]);
      out.rgb[k] = fma(weights[corner], channel, out.rgb[k]);
    }
  }
  for (F& channel : out.rgb) channel = select(present, channel * F(row.scale), F(0.0f));
  return out;
}

/// A volume in three channels, times the row's scale.
template <class L> struct VolumeValue { typename L::Float rgb[3]; };
/// Not inlined, to have one copy of the code: few scenes use it.
template <class L>
[[gnu::noinline]] VolumeValue<L> lookup_volume(const TextureView& view, const VolumeTextureRow& row, Vec3<L> p) {
  alignas(kSimdAlignment) float at[3][L::width];
  const typename L::Float places[3] = {p.x, p.y, p.z};
  for (int axis = 0; axis < 3; ++axis) store(at[axis], places[axis]);
  for (int lane = 0; lane < L::width; ++lane) {
    const Vec3f value = lookup_grid_color(view.grids[row.grid], {at[0][lane], at[1][lane], at[2][lane]}) * row.scale;
    at[0][lane] = value.x, at[1][lane] = value.y, at[2][lane] = value.z;
  }
  VolumeValue<L> out;
  for (int k = 0; k < 3; ++k) load(at[k], out.rgb[k]);
  return out;
}

/// Weight of a wireframe's first child; 1 on shapes without triangles.
template <class L>
SHEAF_INLINE typename L::Float wireframe_share(const TextureView& view, const WireframeRow& row,
                                               const TextureQuery<L>& query) {
  using F = typename L::Float;
  const AttributeValue<L> corner = lookup_attribute<L>(view, {row.first_entry, 1.0f}, query);
  const F b0 = F(1.0f) - query.b1 - query.b2;
  const F distance = min(b0 * corner.rgb[0], min(query.b1 * corner.rgb[1], query.b2 * corner.rgb[2]));
  const float width = row.outer - row.inner;
  const F step = select(distance < F(row.outer), F(0.0f), F(1.0f));
  const F t = width > 0.0f ? clamp((distance - F(row.inner)) * F(1.0f / width), F(0.0f), F(1.0f)) : step;
  return select(corner.coloured, t * t * (F(3.0f) - F(2.0f) * t), F(1.0f));
}

}  // namespace detail

template <class L> void prefetch_texture(const TextureView& view, std::uint32_t texture, Vec2<L> uv) noexcept {
  const TextureRow& row = view.rows[texture];
  switch (row.kind) {
    case TextureKind::kBitmap:
      return detail::with_format(row.bitmap.format, [&]<TexelFormat Format>() SHEAF_LAMBDA_INLINE {
        detail::prefetch_patch<L, Format>(view, row.bitmap, detail::texture_uv<L>(row, uv));
      });
    case TextureKind::kMix:
      prefetch_texture<L>(view, row.mix.amount, uv);
      for (const std::uint32_t child : row.mix.child) prefetch_texture<L>(view, child, uv);
      return;
    case TextureKind::kCheckerboard:
    case TextureKind::kGrid:
      for (const std::uint32_t child : row.checkerboard.child) prefetch_texture<L>(view, child, uv);
      return;
    case TextureKind::kWireframe:
      for (const std::uint32_t child : row.wireframe.child) prefetch_texture<L>(view, child, uv);
      return;
    default:
      return;
  }
}

template <class L>
Float<L> lookup_scalar(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept;

template <class L>
Spectrum<L> lookup_texture(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept {
  using F = typename L::Float;
  const TextureRow& row = view.rows[texture];
  const F zero(0.0f);
  switch (row.kind) {
    case TextureKind::kBitmap:
      return detail::with_format(row.bitmap.format, [&]<TexelFormat Format>() SHEAF_LAMBDA_INLINE -> Spectrum<L> {
        F value[3];
        detail::lookup_bitmap<L, Format>(view, row.bitmap, detail::texture_uv<L>(row, query.uv), value);
        if constexpr (texel_channels(Format) == 1) return {value[0], value[0], value[0], zero};
        return {value[0], value[1], value[2], zero};
      });
    case TextureKind::kCheckerboard:
    case TextureKind::kGrid: {
      const auto first = detail::first_square<L>(row, detail::texture_uv<L>(row, query.uv));
      if (all(first)) return lookup_texture<L>(view, row.checkerboard.child[0], query);
      if (!any(first)) return lookup_texture<L>(view, row.checkerboard.child[1], query);
      return select<L>(first, lookup_texture<L>(view, row.checkerboard.child[0], query),
                       lookup_texture<L>(view, row.checkerboard.child[1], query));
    }
    case TextureKind::kMix: {
      const F t = lookup_scalar<L>(view, row.mix.amount, query);
      return lookup_texture<L>(view, row.mix.child[0], query) * (F(1.0f) - t) +
             lookup_texture<L>(view, row.mix.child[1], query) * t;
    }
    case TextureKind::kMeshAttribute: {
      const detail::AttributeValue<L> value = detail::lookup_attribute<L>(view, row.attribute, query);
      return {value.rgb[0], value.rgb[1], value.rgb[2], zero};
    }
    case TextureKind::kVolume: {
      const detail::VolumeValue<L> value = detail::lookup_volume<L>(view, row.volume, query.p);
      return {value.rgb[0], value.rgb[1], value.rgb[2], zero};
    }
    case TextureKind::kWireframe: {
      const F share = detail::wireframe_share<L>(view, row.wireframe, query);
      const Spectrum<L> first = lookup_texture<L>(view, row.wireframe.child[0], query);
      const Spectrum<L> second = lookup_texture<L>(view, row.wireframe.child[1], query);
      return {lerp(share, second.c0, first.c0), lerp(share, second.c1, first.c1), lerp(share, second.c2, first.c2),
              zero};
    }
    default:
      return {F(row.constant.rgb[0]), F(row.constant.rgb[1]), F(row.constant.rgb[2]), zero};
  }
}

template <class L>
Float<L> lookup_scalar(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept {
  using F = typename L::Float;
  const TextureRow& row = view.rows[texture];
  switch (row.kind) {
    case TextureKind::kBitmap:
      return detail::with_format(row.bitmap.format, [&]<TexelFormat Format>() SHEAF_LAMBDA_INLINE -> F {
        F value[3];
        detail::lookup_bitmap<L, Format>(view, row.bitmap, detail::texture_uv<L>(row, query.uv), value);
        if constexpr (texel_channels(Format) == 1) return value[0];
        return texture_luminance(value);
      });
    case TextureKind::kCheckerboard:
    case TextureKind::kGrid: {
      const auto first = detail::first_square<L>(row, detail::texture_uv<L>(row, query.uv));
      if (all(first)) return lookup_scalar<L>(view, row.checkerboard.child[0], query);
      if (!any(first)) return lookup_scalar<L>(view, row.checkerboard.child[1], query);
      return select(first, lookup_scalar<L>(view, row.checkerboard.child[0], query),
                    lookup_scalar<L>(view, row.checkerboard.child[1], query));
    }
    case TextureKind::kMix:
      return lerp(lookup_scalar<L>(view, row.mix.amount, query), lookup_scalar<L>(view, row.mix.child[0], query),
                  lookup_scalar<L>(view, row.mix.child[1], query));
    case TextureKind::kMeshAttribute: {
      const detail::AttributeValue<L> value = detail::lookup_attribute<L>(view, row.attribute, query);
      return select(value.coloured, texture_luminance(value.rgb), value.rgb[0]);
    }
    case TextureKind::kVolume: {
      const detail::VolumeValue<L> value = detail::lookup_volume<L>(view, row.volume, query.p);
      return view.grids[row.volume.grid].channels == 1 ? value.rgb[0] : texture_luminance(value.rgb);
    }
    case TextureKind::kWireframe:
      return lerp(detail::wireframe_share<L>(view, row.wireframe, query),
                  lookup_scalar<L>(view, row.wireframe.child[1], query),
                  lookup_scalar<L>(view, row.wireframe.child[0], query));
    default:
      return F(row.constant.scalar);
  }
}

template <class L>
Vec2<L> lookup_scalar_gradient(const TextureView& view, std::uint32_t texture, const TextureQuery<L>& query) noexcept {
  using F = typename L::Float;
  const TextureRow& row = view.rows[texture];
  const BitmapRow& bitmap = row.bitmap;
  if (row.kind == TextureKind::kMix) {
    const auto slope = [&](std::uint32_t of) { return lookup_scalar_gradient<L>(view, of, query); };
    const Vec2<L> a = slope(row.mix.child[0]), b = slope(row.mix.child[1]), t = slope(row.mix.amount);
    const F amount = lookup_scalar<L>(view, row.mix.amount, query);
    const F step = lookup_scalar<L>(view, row.mix.child[1], query) - lookup_scalar<L>(view, row.mix.child[0], query);
    return {fma(step, t.x, lerp(amount, a.x, b.x)), fma(step, t.y, lerp(amount, a.y, b.y))};
  }
  if (row.kind != TextureKind::kBitmap || bitmap.filter != TextureFilter::kBilinear) return {F(0.0f), F(0.0f)};
  return detail::with_format(bitmap.format, [&]<TexelFormat Format>() SHEAF_LAMBDA_INLINE -> Vec2<L> {
    const Vec2<L> slopes = detail::bitmap_slopes<L, Format>(view, bitmap, detail::texture_uv<L>(row, query.uv));
    const F du = slopes.x * F(static_cast<float>(bitmap.width)), dv = slopes.y * F(static_cast<float>(bitmap.height));
    const float* m = row.to_uv;
    return {fma(F(m[0]), du, F(m[3]) * dv), fma(F(m[1]), du, F(m[4]) * dv)};
  });
}

template void prefetch_texture(const TextureView&, std::uint32_t, Vec2<Wide>) noexcept;
template void prefetch_texture(const TextureView&, std::uint32_t, Vec2<Scalar>) noexcept;
template Spectrum<Wide> lookup_texture(const TextureView&, std::uint32_t, const TextureQuery<Wide>&) noexcept;
template Float<Wide> lookup_scalar(const TextureView&, std::uint32_t, const TextureQuery<Wide>&) noexcept;
template Vec2<Wide> lookup_scalar_gradient(const TextureView&, std::uint32_t, const TextureQuery<Wide>&) noexcept;
template Spectrum<Scalar> lookup_texture(const TextureView&, std::uint32_t, const TextureQuery<Scalar>&) noexcept;
template Float<Scalar> lookup_scalar(const TextureView&, std::uint32_t, const TextureQuery<Scalar>&) noexcept;
template Vec2<Scalar> lookup_scalar_gradient(const TextureView&, std::uint32_t, const TextureQuery<Scalar>&) noexcept;

}  // namespace sheaf

// Lookups of images. Texel (x, y) of a w x h image, counted from the lower left, lies at uv ((x + 1/2) / w,
// (y + 1/2) / h). Bilinear lookups interpolate the four nearest texels after decoding. NaN coordinates count as 0.
#pragma once

#include "core/simd/prefetch.h"
#include "core/soa/lane_array.h"
#include "scene/textures/bitmap.h"
#include "scene/textures/lookups/lookup.h"

#include <iterator>
#include <type_traits>

namespace sheaf {

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

namespace bitmap_detail {

/// Two neighboring texels along one axis, and the interpolation weight of the second.
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

/// The texels with the nearest centers on both sides of `u`.
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
template <TexelFormat kFormat, class U> SHEAF_INLINE U column_index(U x) {
  constexpr int kShift = tile_shift(kFormat);
  return ((x >> kShift) << (2 * kShift)) + (x & U((1u << kShift) - 1));
}
template <TexelFormat kFormat, class U> SHEAF_INLINE U row_index(U y, std::uint32_t tiles_per_row) {
  constexpr int kShift = tile_shift(kFormat);
  return (((y >> kShift) * U(tiles_per_row)) << (2 * kShift)) + ((y & U((1u << kShift) - 1)) << kShift);
}

/// Converts a byte to its linear value.
template <TexelFormat kFormat, class U> SHEAF_INLINE auto decode_byte(U byte) {
  const auto value = to_float(byte);
  if constexpr (kFormat == TexelFormat::kSrgbByte1 || kFormat == TexelFormat::kSrgbByte4)
    return decode_srgb_byte(value);
  else
    return value * decltype(value)(1.0f / 255.0f);
}

/// A texel in its storage format.
template <class L, TexelFormat kFormat> struct StoredTexel {
  static constexpr bool kBytes = holds_bytes(kFormat);
  std::conditional_t<kBytes, typename L::Uint, typename L::Float> value[kBytes ? 1 : texel_channels(kFormat)];

  static SHEAF_INLINE StoredTexel load(const TexelTile* tiles, typename L::Uint index) {
    const std::uint8_t* bytes = tiles->bytes;
    StoredTexel out;
    if constexpr (kFormat == TexelFormat::kFloat1) {
      out.value[0] = gather(reinterpret_cast<const float*>(bytes), index);
    } else if constexpr (kFormat == TexelFormat::kFloat4) {
      typename L::Float row[4];
      gather_row4<L>(reinterpret_cast<const float*>(bytes), index << 2, row);
      for (int k = 0; k < 3; ++k) out.value[k] = row[k];
    } else if constexpr (texel_channels(kFormat) == 1) {
      out.value[0] = gather_bytes(bytes, index);
    } else {
      out.value[0] = gather(reinterpret_cast<const std::uint32_t*>(bytes), index);
    }
    return out;
  }

  /// The linear value of one channel.
  template <int kChannel> SHEAF_INLINE typename L::Float channel() const {
    if constexpr (!kBytes)
      return value[kChannel];
    else if constexpr (texel_channels(kFormat) == 1)
      return decode_byte<kFormat>(value[0]);
    else if constexpr (kChannel == 2)
      return decode_byte<kFormat>(value[0] >> 16);
    else
      return decode_byte<kFormat>((value[0] >> (8 * kChannel)) & typename L::Uint(0xffu));
  }
};

/// Calls f.operator()<k>() for every channel k of the format.
template <TexelFormat kFormat, class F> SHEAF_INLINE void for_each_channel(F&& f) {
  f.template operator()<0>();
  if constexpr (texel_channels(kFormat) == 3) {
    f.template operator()<1>();
    f.template operator()<2>();
  }
}

/// The four texels around a point: lower left, lower right, upper left, upper right.
template <class L, TexelFormat kFormat> struct Patch {
  StoredTexel<L, kFormat> corner[4];
  typename L::Float tx, ty;
};

template <class L, TexelFormat kFormat>
SHEAF_INLINE Patch<L, kFormat> load_patch(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv) {
  const TexelPair<L> x = texel_pair<L>(bitmap.wrap_u, uv.x, bitmap.width);
  const TexelPair<L> y = texel_pair<L>(bitmap.wrap_v, uv.y, bitmap.height);
  const auto x0 = column_index<kFormat>(x.first), x1 = column_index<kFormat>(x.second);
  const auto y0 = row_index<kFormat>(y.first, bitmap.tiles_per_row),
             y1 = row_index<kFormat>(y.second, bitmap.tiles_per_row);
  const TexelTile* tiles = view.tiles + bitmap.first_tile;
  using Texel = StoredTexel<L, kFormat>;
  return {{Texel::load(tiles, y0 + x0), Texel::load(tiles, y0 + x1), Texel::load(tiles, y1 + x0),
           Texel::load(tiles, y1 + x1)},
          x.t,
          y.t};
}

/// Value of an image, in one or three channels.
template <class L, TexelFormat kFormat>
SHEAF_INLINE void lookup_bitmap(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv, typename L::Float* out) {
  if (bitmap.filter == TextureFilter::kNearest) {
    const auto x = nearest_texel<L>(bitmap.wrap_u, uv.x, bitmap.width);
    const auto y = nearest_texel<L>(bitmap.wrap_v, uv.y, bitmap.height);
    const auto index = row_index<kFormat>(y, bitmap.tiles_per_row) + column_index<kFormat>(x);
    const auto texel = StoredTexel<L, kFormat>::load(view.tiles + bitmap.first_tile, index);
    for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE { out[K] = texel.template channel<K>(); });
    return;
  }
  const auto patch = load_patch<L, kFormat>(view, bitmap, uv);
  for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE {
    const auto value = [&](int corner) SHEAF_LAMBDA_INLINE { return patch.corner[corner].template channel<K>(); };
    out[K] = lerp(patch.ty, lerp(patch.tx, value(0), value(1)), lerp(patch.tx, value(2), value(3)));
  });
}

/// Derivatives of an image along its axes, per texel; of the luminance for colors.
template <class L, TexelFormat kFormat>
SHEAF_INLINE Vec2<L> bitmap_slopes(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv) {
  const auto patch = load_patch<L, kFormat>(view, bitmap, uv);
  typename L::Float corner[4];
  for (int i = 0; i < 4; ++i) {
    typename L::Float value[3];
    for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE { value[K] = patch.corner[i].template channel<K>(); });
    if constexpr (texel_channels(kFormat) == 1)
      corner[i] = value[0];
    else
      corner[i] = texture_luminance(value);
  }
  return {lerp(patch.ty, corner[1] - corner[0], corner[3] - corner[2]),
          lerp(patch.tx, corner[2] - corner[0], corner[3] - corner[1])};
}

/// Prefetches the tiles of two opposite corners of the patch, which nearly always cover it.
template <class L, TexelFormat kFormat>
SHEAF_INLINE void prefetch_patch(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv) {
  const TexelPair<L> x = texel_pair<L>(bitmap.wrap_u, uv.x, bitmap.width);
  const TexelPair<L> y = texel_pair<L>(bitmap.wrap_v, uv.y, bitmap.height);
  constexpr int kShift = tile_shift(kFormat);
  const typename L::Uint per_row(bitmap.tiles_per_row);
  const LaneArray<typename L::Uint> near((y.first >> kShift) * per_row + (x.first >> kShift)),
      far((y.second >> kShift) * per_row + (x.second >> kShift));
  const TexelTile* const first = view.tiles + bitmap.first_tile;
  for (int lane = 0; lane < L::width; ++lane) {
    prefetch(first + near[lane]);
    prefetch(first + far[lane]);
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

}  // namespace bitmap_detail

struct BitmapTexture {
  using Description = BitmapDescription;

  template <class L> static SHEAF_INLINE Spectrum<L> color(const TextureLookup<L>& at) {
    using F = typename L::Float;
    const auto bitmap = at.row.template data<BitmapRow>();
    return bitmap_detail::with_format(bitmap.format, [&]<TexelFormat kFormat>() SHEAF_LAMBDA_INLINE -> Spectrum<L> {
      F value[3];
      bitmap_detail::lookup_bitmap<L, kFormat>(at.view, bitmap, at.uv(), value);
      if constexpr (texel_channels(kFormat) == 1) return {value[0], value[0], value[0], F(0.0f)};
      return {value[0], value[1], value[2], F(0.0f)};
    });
  }
  template <class L> static SHEAF_INLINE Float<L> scalar(const TextureLookup<L>& at) {
    const auto bitmap = at.row.template data<BitmapRow>();
    return bitmap_detail::with_format(bitmap.format, [&]<TexelFormat kFormat>() SHEAF_LAMBDA_INLINE -> Float<L> {
      Float<L> value[3];
      bitmap_detail::lookup_bitmap<L, kFormat>(at.view, bitmap, at.uv(), value);
      if constexpr (texel_channels(kFormat) == 1) return value[0];
      return texture_luminance(value);
    });
  }
  /// The slope of the bilinear patch.
  template <class L> static SHEAF_INLINE Vec2<L> slopes(const TextureLookup<L>& at) {
    using F = typename L::Float;
    const auto bitmap = at.row.template data<BitmapRow>();
    if (bitmap.filter != TextureFilter::kBilinear) return {F(0.0f), F(0.0f)};
    return bitmap_detail::with_format(bitmap.format, [&]<TexelFormat kFormat>() SHEAF_LAMBDA_INLINE -> Vec2<L> {
      const Vec2<L> slopes = bitmap_detail::bitmap_slopes<L, kFormat>(at.view, bitmap, at.uv());
      const F du = slopes.x * F(static_cast<float>(bitmap.width)), dv = slopes.y * F(static_cast<float>(bitmap.height));
      const float* m = at.row.to_uv;
      return {fma(F(m[0]), du, F(m[3]) * dv), fma(F(m[1]), du, F(m[4]) * dv)};
    });
  }
  template <class L> static SHEAF_INLINE void prefetch(const TextureView& view, const TextureRow& row, Vec2<L> uv) {
    const auto bitmap = row.data<BitmapRow>();
    bitmap_detail::with_format(bitmap.format, [&]<TexelFormat kFormat>() SHEAF_LAMBDA_INLINE {
      bitmap_detail::prefetch_patch<L, kFormat>(view, bitmap, texture_uv<L>(row, uv));
    });
  }
};

template <> struct LookupOf<BitmapDescription> { using Type = BitmapTexture; };

}  // namespace sheaf

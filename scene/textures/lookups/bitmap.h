// Lookups of images. Texel (x, y) of a w x h image, counted from the lower left, lies at uv ((x + 1/2) / w,
// (y + 1/2) / h). Bilinear lookups interpolate the four nearest texels after decoding. NaN coordinates count as 0.
#pragma once

#include "core/simd/prefetch.h"
#include "core/soa/lane_array.h"
#include "core/soa/record_table.h"
#include "scene/textures/bitmap.h"
#include "scene/textures/lookups/lookup.h"
#include "scene/textures/tiled_image.h"

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
template <class L> SHEAF_INLINE TexelPair<L> texel_pair(TextureWrap wrap, typename L::Float u, typename L::Uint n) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const F x = fma(wrap_coordinate(wrap, u), to_float(n), F(0.5f));
  const F above = floor(x);
  const U second = to_uint(above), one(1u);  // from 0 to n, or to 2 n if mirrored
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
  constexpr TileShift kShift = tile_shift(kFormat);
  return ((x >> kShift.x) << kShift.texels()) + (x & U((1u << kShift.x) - 1));
}
template <TexelFormat kFormat, class U> SHEAF_INLINE U row_index(U y, U tiles_per_row) {
  constexpr TileShift kShift = tile_shift(kFormat);
  return (((y >> kShift.y) * tiles_per_row) << kShift.texels()) + ((y & U((1u << kShift.y) - 1)) << kShift.x);
}

/// The tiles of an image, or of a mip level of it in each lane.
template <class L> struct TexelGrid {
  const TexelLine* tiles;
  MipLevelRecord<L> extent;  ///< first_tile counts from `tiles`
};

template <class L> SHEAF_INLINE TexelGrid<L> base_grid(const TextureView& view, const BitmapRow& bitmap) {
  using U = typename L::Uint;
  return {view.images[bitmap.image].tiles, {U(0u), U(bitmap.tiles_per_row), U(bitmap.width), U(bitmap.height)}};
}

/// Mip levels >= 1, one for each lane.
template <class L>
SHEAF_INLINE TexelGrid<L> mip_grid(const TextureView& view, const BitmapRow& bitmap, typename L::Uint level) {
  using U = typename L::Uint;
  const TexelImage& image = view.images[bitmap.image];
  return {image.mip_tiles, gather_rows<L>(image.mip_levels, level - U(1u))};
}

/// Maximum number of points along the axis of a footprint.
inline constexpr float kMaxFootprintPoints = 8;

/// Squared width of a footprint in texels of the image, the smaller one of both directions, but at least 1.
template <class L>
SHEAF_INLINE typename L::Float squared_texels(const TextureRow& row, const BitmapRow& bitmap, Vec2<L> footprint) {
  using F = typename L::Float;
  const float* m = row.to_uv;
  const float width = static_cast<float>(bitmap.width), height = static_cast<float>(bitmap.height);
  const auto squared = [](float x) { return F(x * x); };
  const F across = fma(squared(m[0] * width), footprint.x, squared(m[1] * width) * footprint.y);
  const F up = fma(squared(m[3] * height), footprint.x, squared(m[4] * height) * footprint.y);
  return max(min(across, up), F(1.0f));
}

/// The mip level whose texels are at least half as wide as the footprint, and at most as wide. 0: the image itself.
/// Lookups interpolate, so wider texels would blur.
template <class L> SHEAF_INLINE typename L::Uint mip_level(const BitmapRow& bitmap, typename L::Float squared_texels) {
  using U = typename L::Uint;
  // Half the binary exponent
  return min(((float_bits(squared_texels) >> 23) - U(127u)) >> 1, U(mip_level_count(bitmap.width, bitmap.height)));
}

/// Computes the fine levels if a lookup needs them first.
template <class U> SHEAF_INLINE void ensure_levels(const TexelImage& image, U level) {
  if (image.levels->has_fine.load(std::memory_order_acquire)) return;
  if (any((level != U(0u)) & (level < U(kFirstCoarseLevel)))) fill_fine_levels(*image.levels);
}

/// Points along the axis of a footprint, in the texture's coordinates: `count` of them from `first` on, `step` apart.
template <class L> struct FootprintPoints {
  Vec2<L> first, step;
  typename L::Float count;
};

/// Points that are at most as far apart as the footprint is wide, unless it takes more than kMaxFootprintPoints.
template <class L>
SHEAF_INLINE FootprintPoints<L> footprint_points(const TextureRow& row, const BitmapRow& bitmap, Vec2<L> uv,
                                                 Vec2<L> axis, typename L::Float squared_texels) {
  using F = typename L::Float;
  const float* m = row.to_uv;
  axis = {fma(F(m[0]), axis.x, F(m[1]) * axis.y), fma(F(m[3]), axis.x, F(m[4]) * axis.y)};
  const F across = axis.x * F(static_cast<float>(bitmap.width)), up = axis.y * F(static_cast<float>(bitmap.height));
  const F gaps = min(floor(sqrt(fma(across, across, up * up) / squared_texels) + F(0.5f)), F(kMaxFootprintPoints - 1));
  const auto several = gaps >= F(1.0f);
  const F fraction = F(1.0f) / select(several, gaps, F(1.0f)), half(0.5f);
  return {{select(several, uv.x - axis.x * half, uv.x), select(several, uv.y - axis.y * half, uv.y)},
          {axis.x * fraction, axis.y * fraction},
          select(several, gaps + F(1.0f), F(1.0f))};
}

/// Converts a byte to its linear value.
template <TexelFormat kFormat, class U> SHEAF_INLINE auto decode_byte(U byte) {
  const auto value = to_float(byte);
  if constexpr (kFormat == TexelFormat::kSrgbByte1 || kFormat == TexelFormat::kSrgbByte3)
    return decode_srgb_byte(value);
  else
    return value * decltype(value)(1.0f / 255.0f);
}

/// Converts a finite number of 16 bits (binary16), exactly.
template <class L> SHEAF_INLINE typename L::Float decode_half(typename L::Uint half) {
  using F = typename L::Float;
  using U = typename L::Uint;
  constexpr std::uint32_t kBias = (127 - 15) << 23;
  const U magnitude = half & U(0x7fffu), sign = (half & U(0x8000u)) << 16;
  const F mantissa = to_float(magnitude);
  const F value = select(mantissa < F(1024.0f), mantissa * F(0x1p-24f), bits_float((magnitude << 13) + U(kBias)));
  return bits_float(float_bits(value) | sign);
}

/// A texel in its storage format.
template <class L, TexelFormat kFormat> struct StoredTexel {
  static constexpr bool kBytes = holds_bytes(kFormat), kHalves = holds_halves(kFormat);
  /// One word of up to three bytes, words of up to two halves, or floats.
  static constexpr int kWords = kBytes ? 1 : kHalves ? (texel_channels(kFormat) + 1) / 2 : texel_channels(kFormat);
  std::conditional_t<kBytes || kHalves, typename L::Uint, typename L::Float> value[kWords];

  static SHEAF_INLINE StoredTexel load(const std::uint8_t* bytes, typename L::Uint index) {
    StoredTexel out;
    if constexpr (kFormat == TexelFormat::kFloat1) {
      out.value[0] = gather(reinterpret_cast<const float*>(bytes), index);
    } else if constexpr (kFormat == TexelFormat::kFloat4) {
      typename L::Float row[4];
      gather_row4<L>(reinterpret_cast<const float*>(bytes), index << 2, row);
      for (int k = 0; k < 3; ++k) out.value[k] = row[k];
    } else if constexpr (kHalves) {
      using U = typename L::Uint;
      const auto* words = reinterpret_cast<const std::uint32_t*>(bytes);
      if constexpr (kFormat == TexelFormat::kHalf4) {
        const U first = index << 1;
        out.value[0] = gather(words, first);
        out.value[1] = gather(words, first + U(1u));
      } else {
        const U both = gather(words, index >> 1);
        out.value[0] = select((index & U(1u)) == U(0u), both & U(0xffffu), both >> 16);
      }
    } else if constexpr (texel_channels(kFormat) == 1) {
      out.value[0] = gather_bytes(bytes, index);
    } else {
      out.value[0] = gather_unaligned(bytes, (index << 1) + index);  // the fourth byte belongs to the next texel
    }
    return out;
  }

  /// The linear value of one channel.
  template <int kChannel> SHEAF_INLINE typename L::Float channel() const {
    if constexpr (kHalves) {
      const auto word = value[kChannel / 2];
      return decode_half<L>(kChannel % 2 == 1 ? word >> 16 : word & typename L::Uint(0xffffu));
    } else if constexpr (!kBytes)
      return value[kChannel];
    else if constexpr (texel_channels(kFormat) == 1)
      return decode_byte<kFormat>(value[0]);
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
SHEAF_INLINE Patch<L, kFormat> load_patch(const TexelGrid<L>& grid, const BitmapRow& bitmap, Vec2<L> uv) {
  const TexelPair<L> x = texel_pair<L>(bitmap.wrap_u, uv.x, grid.extent.width);
  const TexelPair<L> y = texel_pair<L>(bitmap.wrap_v, uv.y, grid.extent.height);
  const auto x0 = column_index<kFormat>(x.first), x1 = column_index<kFormat>(x.second);
  const auto first = grid.extent.first_tile << tile_shift(kFormat).texels();
  const auto y0 = first + row_index<kFormat>(y.first, grid.extent.tiles_per_row),
             y1 = first + row_index<kFormat>(y.second, grid.extent.tiles_per_row);
  using Texel = StoredTexel<L, kFormat>;
  const std::uint8_t* const bytes = grid.tiles->bytes;
  return {{Texel::load(bytes, y0 + x0), Texel::load(bytes, y0 + x1), Texel::load(bytes, y1 + x0),
           Texel::load(bytes, y1 + x1)},
          x.t,
          y.t};
}

/// Interpolates between the four texels around a point, in one or three channels.
template <class L, TexelFormat kFormat>
SHEAF_INLINE void interpolate_texels(const TexelGrid<L>& grid, const BitmapRow& bitmap, Vec2<L> uv,
                                     typename L::Float* out) {
  const auto patch = load_patch<L, kFormat>(grid, bitmap, uv);
  for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE {
    const auto value = [&](int corner) SHEAF_LAMBDA_INLINE { return patch.corner[corner].template channel<K>(); };
    out[K] = lerp(patch.ty, lerp(patch.tx, value(0), value(1)), lerp(patch.tx, value(2), value(3)));
  });
}

/// Value of an image, in one or three channels.
template <class L, TexelFormat kFormat>
SHEAF_INLINE void lookup_bitmap(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv, typename L::Float* out) {
  if (bitmap.filter == TextureFilter::kNearest) {
    const auto x = nearest_texel<L>(bitmap.wrap_u, uv.x, bitmap.width);
    const auto y = nearest_texel<L>(bitmap.wrap_v, uv.y, bitmap.height);
    const auto index = row_index<kFormat>(y, typename L::Uint(bitmap.tiles_per_row)) + column_index<kFormat>(x);
    const auto texel = StoredTexel<L, kFormat>::load(view.images[bitmap.image].tiles->bytes, index);
    for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE { out[K] = texel.template channel<K>(); });
    return;
  }
  interpolate_texels<L, kFormat>(base_grid<L>(view, bitmap), bitmap, uv, out);
}

/// Value of an image in mip levels.
template <class L, TexelFormat kFormat>
SHEAF_INLINE void lookup_level(const TextureView& view, const BitmapRow& bitmap, typename L::Uint level, Vec2<L> uv,
                               typename L::Float* out) {
  using U = typename L::Uint;
  const auto is_base = level == U(0u);
  if (all(is_base)) return interpolate_texels<L, kFormat>(base_grid<L>(view, bitmap), bitmap, uv, out);
  interpolate_texels<L, kFormat>(mip_grid<L>(view, bitmap, select(is_base, U(1u), level)), bitmap, uv, out);
  if (!any(is_base)) return;
  typename L::Float base[3];
  interpolate_texels<L, kFormat>(base_grid<L>(view, bitmap), bitmap, uv, base);
  for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE { out[K] = select(is_base, base[K], out[K]); });
}

/// Mean over the footprint.
template <class L, TexelFormat kFormat>
SHEAF_INLINE void lookup_footprint(const TextureLookup<L>& at, const BitmapRow& bitmap, typename L::Float* out) {
  using F = typename L::Float;
  if (at.view.images[bitmap.image].mip_levels == nullptr)
    return lookup_bitmap<L, kFormat>(at.view, bitmap, at.uv(), out);
  const F texels = squared_texels<L>(at.row, bitmap, at.query.footprint);
  const auto level = mip_level<L>(bitmap, texels);
  ensure_levels(at.view.images[bitmap.image], level);
  FootprintPoints<L> points = footprint_points<L>(at.row, bitmap, at.uv(), at.query.footprint_axis, texels);
  lookup_level<L, kFormat>(at.view, bitmap, level, points.first, out);
  if (!any(points.count > F(1.0f))) return;
  for (float k = 1; k < kMaxFootprintPoints; ++k) {
    const auto on = points.count > F(k);
    if (!any(on)) break;
    const Vec2<L> uv{fma(F(k), points.step.x, points.first.x), fma(F(k), points.step.y, points.first.y)};
    F next[3];
    lookup_level<L, kFormat>(at.view, bitmap, level, uv, next);
    for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE { out[K] = select(on, out[K] + next[K], out[K]); });
  }
  const F weight = F(1.0f) / points.count;
  for_each_channel<kFormat>([&]<int K>() SHEAF_LAMBDA_INLINE { out[K] = out[K] * weight; });
}

/// Derivatives of an image along its axes, per texel; of the luminance for colors.
template <class L, TexelFormat kFormat>
SHEAF_INLINE Vec2<L> bitmap_slopes(const TextureView& view, const BitmapRow& bitmap, Vec2<L> uv) {
  const auto patch = load_patch<L, kFormat>(base_grid<L>(view, bitmap), bitmap, uv);
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
SHEAF_INLINE void prefetch_patch(const TexelGrid<L>& grid, const BitmapRow& bitmap, Vec2<L> uv, std::uint32_t lanes) {
  const TexelPair<L> x = texel_pair<L>(bitmap.wrap_u, uv.x, grid.extent.width);
  const TexelPair<L> y = texel_pair<L>(bitmap.wrap_v, uv.y, grid.extent.height);
  constexpr TileShift kShift = tile_shift(kFormat);
  const auto tile = [&](typename L::Uint column, typename L::Uint row) SHEAF_LAMBDA_INLINE {
    return grid.extent.first_tile + (row >> kShift.y) * grid.extent.tiles_per_row + (column >> kShift.x);
  };
  const LaneArray<typename L::Uint> near(tile(x.first, y.first)), far(tile(x.second, y.second));
  constexpr std::size_t kBytes = bytes_per_tile(kFormat);
  const auto prefetch_tile = [&](std::uint32_t index) SHEAF_LAMBDA_INLINE {
    const std::uint8_t* const bytes = grid.tiles->bytes + index * kBytes;
    prefetch(bytes);
    if constexpr (sizeof(TexelLine) % kBytes != 0) prefetch(bytes + kBytes - 1);  // it may continue in the next line
  };
  for_each_lane(lanes, [&](int lane) SHEAF_LAMBDA_INLINE {
    prefetch_tile(near[lane]);
    prefetch_tile(far[lane]);
  });
}

/// Calls f with the format as a template argument.
template <class F> SHEAF_INLINE auto with_format(TexelFormat format, F&& f) {
  switch (format) {
    case TexelFormat::kByte1:
      return f.template operator()<TexelFormat::kByte1>();
    case TexelFormat::kByte3:
      return f.template operator()<TexelFormat::kByte3>();
    case TexelFormat::kSrgbByte1:
      return f.template operator()<TexelFormat::kSrgbByte1>();
    case TexelFormat::kSrgbByte3:
      return f.template operator()<TexelFormat::kSrgbByte3>();
    case TexelFormat::kHalf1:
      return f.template operator()<TexelFormat::kHalf1>();
    case TexelFormat::kHalf4:
      return f.template operator()<TexelFormat::kHalf4>();
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
      bitmap_detail::lookup_footprint<L, kFormat>(at, bitmap, value);
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
  template <class L>
  static SHEAF_INLINE void prefetch(const TextureView& view, const TextureRow& row, Vec2<L> uv, Vec2<L> footprint) {
    using U = typename L::Uint;
    const auto bitmap = row.data<BitmapRow>();
    U level(0u);
    if (view.images[bitmap.image].mip_levels != nullptr)
      level = bitmap_detail::mip_level<L>(bitmap, bitmap_detail::squared_texels<L>(row, bitmap, footprint));
    const auto is_base = level == U(0u);
    const Vec2<L> at = texture_uv<L>(row, uv);
    bitmap_detail::with_format(bitmap.format, [&]<TexelFormat kFormat>() SHEAF_LAMBDA_INLINE {
      using namespace bitmap_detail;
      if (any(is_base)) prefetch_patch<L, kFormat>(base_grid<L>(view, bitmap), bitmap, at, mask_bits(is_base));
      if (all(is_base)) return;
      prefetch_patch<L, kFormat>(mip_grid<L>(view, bitmap, select(is_base, U(1u), level)), bitmap, at,
                                 mask_bits(!is_base));
    });
  }
};

template <> struct LookupOf<BitmapDescription> { using Type = BitmapTexture; };

}  // namespace sheaf

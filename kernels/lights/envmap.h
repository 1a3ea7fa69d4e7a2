// Environment maps: radiance by direction, and directions in proportion to it, generic in the lane.
// scene/tables/envmap.h says how a map lies on the sphere.
#pragma once

#include "core/distribution.h"
#include "core/uplift.h"
#include "core/warp.h"
#include "scene/tables/instance.h"

namespace sheaf {

/// A map's radiance in a direction, and the density with which sample_envmap() finds it.
template <class L> struct EnvmapValue {
  Spectrum<L> radiance;  ///< spectral mode: a factor on D65
  typename L::Float pdf_solid_angle;
};

/// A direction drawn from a map.
template <class L> struct EnvmapSample {
  Vec3<L> direction;     ///< world space, unit length
  Spectrum<L> radiance;  ///< spectral mode: a factor on D65
  typename L::Float pdf_solid_angle;  ///< 0: there is no such direction
};

namespace detail {

/// A place between four nodes: those of `row` and the one below, of `column` and the next one around.
template <class L> struct EnvmapPlace {
  typename L::Uint column, row;
  typename L::Float x, y;  ///< from the first to the second, in [0, 1]
};

template <class L> SHEAF_INLINE Uint<L> next_column(const EnvmapView& map, Uint<L> column) {
  const Uint<L> next = column + Uint<L>(1u);
  return select(next == Uint<L>(map.width), Uint<L>(0u), next);
}

/// Radiance, and density over the unit square.
template <class L> struct EnvmapMix {
  Spectrum<L> radiance;
  typename L::Float density;
};

/// What lies between four nodes. Spectral mode: at `lambda`.
template <class L, ColorMode Mode>
SHEAF_INLINE EnvmapMix<L> mix_nodes(const EnvmapView& map, const EnvmapPlace<L>& at, const Spectrum<L>& lambda) {
  using F = Float<L>;
  using U = Uint<L>;
  const U above = at.row * U(map.width), below = above + U(map.width), next = next_column<L>(map, at.column);
  const U first[4] = {(above + at.column) << 2, (above + next) << 2, (below + at.column) << 2, (below + next) << 2};
  const auto mix = [&](F a, F b, F c, F d)
                       SHEAF_LAMBDA_INLINE { return lerp(at.y, lerp(at.x, a, b), lerp(at.x, c, d)); };
  F corner[4][4], out[4];
  if constexpr (Mode == ColorMode::kSpectral) {
    Spectrum<L> shape[4];
    for (int k = 0; k < 4; ++k) {
      gather_row4<L>(map.spectra, first[k], corner[k]);
      shape[k] = evaluate(SigmoidPolynomial<L>{corner[k][0], corner[k][1], corner[k][2]}, lambda);
    }
    const Spectrum<L> mixed{mix(shape[0].c0, shape[1].c0, shape[2].c0, shape[3].c0),
                            mix(shape[0].c1, shape[1].c1, shape[2].c1, shape[3].c1),
                            mix(shape[0].c2, shape[1].c2, shape[2].c2, shape[3].c2),
                            mix(shape[0].c3, shape[1].c3, shape[2].c3, shape[3].c3)};
    const auto density = [&](int k) SHEAF_LAMBDA_INLINE { return gather(map.nodes, first[k] + U(3u)); };
    return {mixed * mix(corner[0][3], corner[1][3], corner[2][3], corner[3][3]),
            mix(density(0), density(1), density(2), density(3))};
  }
  for (int k = 0; k < 4; ++k) gather_row4<L>(map.nodes, first[k], corner[k]);
  for (int c = 0; c < 4; ++c) out[c] = mix(corner[0][c], corner[1][c], corner[2][c], corner[3][c]);
  return {{out[0], out[1], out[2], F(0.0f)}, out[3]};
}

/// Density per solid angle of one over the unit square: the square's area element is 2 pi^2 sin theta.
template <class F> SHEAF_INLINE F envmap_solid_angle_pdf(F density, F sin_theta) {
  const auto usable = sin_theta > F(0.0f);
  return select(usable, density * F(0.5f * kInvPi * kInvPi) / select(usable, sin_theta, F(1.0f)), F(0.0f));
}

/// x in [0, 1] with a density that goes from `a` to `b`, in proportion: the inverse of its CDF (Pharr et al., 4th ed.,
/// A.4.1, without cancellation).
template <class F> SHEAF_INLINE F sample_linear(F u, F a, F b) {
  const F root = sqrt(lerp(u, a * a, b * b));
  const F denominator = a + root;
  const auto usable = denominator > F(0.0f);
  return select(usable, clamp(u * (a + b) / select(usable, denominator, F(1.0f)), F(0.0f), F(1.0f)), u);
}

/// Where `u` lies inside [begin, begin + width), as a share.
template <class F> SHEAF_INLINE F share_of(F u, F begin, F width) {
  const auto usable = width > F(0.0f);
  return select(usable, clamp((u - begin) / select(usable, width, F(1.0f)), F(0.0f), F(1.0f)), F(0.5f));
}

/// The column and the place in it, by u, on the line between two rows of nodes that at.row and at.y tell. The line's
/// density is linear between nodes, and its CDF the mix of those of the two rows.
template <class L> SHEAF_INLINE void sample_column(const EnvmapView& map, Float<L> u, EnvmapPlace<L>& at) {
  using F = Float<L>;
  using U = Uint<L>;
  const U stride(map.width + 1), above = at.row * stride, below = above + stride, last(map.width);
  const auto sum = [&](U column) SHEAF_LAMBDA_INLINE {
    return lerp(at.y, gather(map.conditional, above + column), gather(map.conditional, below + column));
  };
  const F target = u * sum(last);
  U column(0u);
  for (std::uint32_t step = std::bit_floor(map.width - 1); step != 0; step >>= 1) {
    const U probe = min(column + U(step), last - U(1u));
    column = select(sum(probe) <= target, probe, column);
  }
  const F begin = sum(column);
  const F share = share_of(target, begin, sum(column + U(1u)) - begin);
  const auto density = [&](U i) SHEAF_LAMBDA_INLINE {
    const U word = at.row * U(map.width) + i;
    return lerp(at.y, gather(map.nodes, (word << 2) + U(3u)), gather(map.nodes, ((word + U(map.width)) << 2) + U(3u)));
  };
  at.column = column;
  at.x = sample_linear(share, density(column), density(next_column<L>(map, column)));
}

}  // namespace detail

/// The radiance that comes from `direction`, of unit length. Spectral mode: at `lambda`.
template <class L, ColorMode Mode = ColorMode::kRgb>
SHEAF_INLINE EnvmapValue<L> lookup_envmap(const EnvmapView& map, Vec3<L> direction, const Spectrum<L>& lambda = {}) {
  using F = Float<L>;
  using U = Uint<L>;
  const float* m = map.to_map;
  const F x = fma(F(m[0]), direction.x, fma(F(m[1]), direction.y, F(m[2]) * direction.z));
  const F y = fma(F(m[3]), direction.x, fma(F(m[4]), direction.y, F(m[5]) * direction.z));
  const F z = fma(F(m[6]), direction.x, fma(F(m[7]), direction.y, F(m[8]) * direction.z));
  const F sin_theta = sqrt(x * x + z * z);
  const F turn = atan2(x, -z) * F(0.5f * kInvPi);
  const F columns(static_cast<float>(map.width)), rows(static_cast<float>(map.height - 1));
  // From 0 to W: the node before is one less, the node after this one.
  const F across = clamp((turn - floor(turn)) * columns + F(0.5f), F(0.5f), columns + F(0.5f));
  const F down = clamp(atan2(sin_theta, y) * F(kInvPi), F(0.0f), F(1.0f)) * rows;
  const U after = to_uint(across);
  detail::EnvmapPlace<L> at;
  at.column = select(after == U(0u), U(map.width - 1), after - U(1u));
  at.x = across - to_float(after);
  at.row = min(to_uint(down), U(map.height - 2));
  at.y = down - to_float(at.row);
  const auto value = detail::mix_nodes<L, Mode>(map, at, lambda);
  return {value.radiance, detail::envmap_solid_angle_pdf(value.density, sin_theta)};
}

/// A direction by u, v in [0, 1): u chooses the longitude, v the polar angle, each by inversion, so that what is
/// stratified stays so. Spectral mode: radiance at `lambda`.
template <class L, ColorMode Mode = ColorMode::kRgb>
SHEAF_INLINE EnvmapSample<L> sample_envmap(const EnvmapView& map, Float<L> u, Float<L> v,
                                           const Spectrum<L>& lambda = {}) {
  using F = Float<L>;
  using U = Uint<L>;
  detail::EnvmapPlace<L> at;
  const CdfCell<L> cell = find_cell<L>(map.marginal, U(0u), map.height - 1, v);
  at.row = cell.index;
  // A row of nodes counts by its sum.
  const U first_end = (at.row + U(1u)) * U(map.width + 1) - U(1u);
  at.y = detail::sample_linear(detail::share_of(v, cell.begin, cell.probability), gather(map.conditional, first_end),
                               gather(map.conditional, first_end + U(map.width + 1)));
  detail::sample_column<L>(map, u, at);
  const auto value = detail::mix_nodes<L, Mode>(map, at, lambda);

  const F across = (to_float(at.column) + F(0.5f) + at.x) * F(1.0f / static_cast<float>(map.width));
  const F down = (to_float(at.row) + at.y) * F(1.0f / static_cast<float>(map.height - 1));
  const auto longitude = sincos_2pi<L>(across - floor(across));
  const auto polar = sincos_2pi<L>(down * F(0.5f));
  const F sin_theta = max(polar.sin, F(0.0f));
  const Vec3<L> local{longitude.sin * sin_theta, polar.cos, -longitude.cos * sin_theta};
  const float* m = map.to_map;
  EnvmapSample<L> out;
  out.direction = {fma(F(m[0]), local.x, fma(F(m[3]), local.y, F(m[6]) * local.z)),
                   fma(F(m[1]), local.x, fma(F(m[4]), local.y, F(m[7]) * local.z)),
                   fma(F(m[2]), local.x, fma(F(m[5]), local.y, F(m[8]) * local.z))};
  out.radiance = value.radiance;
  out.pdf_solid_angle = detail::envmap_solid_angle_pdf(value.density, sin_theta);
  return out;
}

}  // namespace sheaf

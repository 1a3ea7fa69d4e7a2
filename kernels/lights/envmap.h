// Environment maps: radiance lookup by direction, and sampling of directions in proportion to it. Generic in the lane
// policy. scene/tables/envmap.h defines the parameterization.
#pragma once

#include "core/color/uplift.h"
#include "core/sampling/quantile_table.h"
#include "core/sampling/warp.h"
#include "core/soa/lane_array.h"
#include "scene/tables/envmap.h"
#include "scene/tables/instance.h"

namespace sheaf {

/// Radiance of a map in a direction, and the pdf with which sample_envmap() returns that direction.
template <class L> struct EnvmapValue {
  Spectrum<L> radiance;  ///< spectral mode: a factor on D65
  typename L::Float pdf_solid_angle;
};

/// A direction sampled from a map.
template <class L> struct EnvmapSample {
  Vec3<L> direction;                  ///< world space, unit length
  Spectrum<L> radiance;               ///< spectral mode: a factor on D65
  typename L::Float pdf_solid_angle;  ///< 0: invalid
};

namespace detail {

/// A cell by its column and row.
template <class L> struct EnvmapCell { typename L::Uint column, row; };

/// Position in a cell, in [0, 1]: x from its first column to the next, y from its upper row to the lower.
template <class L> struct EnvmapCellPosition { typename L::Float x, y; };

/// Table entries of a cell and its four nodes, in the order upper left, lower left, upper right, lower right.
template <class L> struct EnvmapNodes {
  typename L::Float radiance[4][3];  ///< as returned by envmap_value()
  typename L::Float brightness[4];   ///< see envmap_brightness()
  typename L::Float density;         ///< of the cell, per unit area of the square
};

template <class L> SHEAF_INLINE EnvmapNodes<L> load_nodes(const EnvmapView& map, const EnvmapCell<L>& cell) {
  using U = Uint<L>;
  const U column = cell.row * U(map.width + 1) + cell.column;
  RowPointers<L> rows(map.columns, column);
  EnvmapNodes<L> nodes;
  for (int side = 0; side < 2; ++side) {
    Float<L> words[4];
    rows.read_four(words);
    for (int k = 0; k < 6; ++k) {
      const U word = float_bits(words[k / 2]);
      nodes.radiance[2 * side + k / 3][k % 3] = envmap_value<L>(k % 2 == 0 ? word & U(0xffffu) : word >> 16);
    }
    if (side == 0) nodes.density = words[3];
  }
  for (int k = 0; k < 4; ++k) {
    const Float<L>* const rgb = nodes.radiance[k];
    nodes.brightness[k] = envmap_brightness<L>(rgb[0], rgb[1], rgb[2], map.offset);
  }
  return nodes;
}

/// Bilinear interpolation of four values in the order of EnvmapNodes.
template <class L>
SHEAF_INLINE Float<L> mix(const EnvmapCellPosition<L>& at, Float<L> a, Float<L> b, Float<L> c, Float<L> d) {
  return lerp(at.x, lerp(at.y, a, b), lerp(at.y, c, d));
}

/// Density on the unit square: that of the cell, distributed in proportion to the interpolated brightness.
template <class L> SHEAF_INLINE Float<L> density_at(const EnvmapNodes<L>& nodes, const EnvmapCellPosition<L>& at) {
  using F = Float<L>;
  const F* const b = nodes.brightness;
  const F sum = (b[0] + b[1]) + (b[2] + b[3]);
  const auto uneven = sum > F(0.0f);
  const F fraction = F(4.0f) * mix<L>(at, b[0], b[1], b[2], b[3]) / select(uneven, sum, F(1.0f));
  return nodes.density * select(uneven, fraction, F(1.0f));
}

/// Radiance at a position in a cell. Spectral mode: at `lambda`.
template <class L, ColorMode kMode>
SHEAF_INLINE Spectrum<L> radiance_at(const EnvmapView& map, const EnvmapNodes<L>& nodes, const EnvmapCell<L>& cell,
                                     const EnvmapCellPosition<L>& at, const Spectrum<L>& lambda) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto between = [&](F a, F b, F c, F d) SHEAF_LAMBDA_INLINE { return mix<L>(at, a, b, c, d); };
  if constexpr (kMode == ColorMode::kSpectral) {
    const U above = cell.row * U(map.width), below = above + U(map.width), last(map.width - 1);
    const U next = select(cell.column == last, U(0u), cell.column + U(1u));
    const U node[4] = {above + cell.column, below + cell.column, above + next, below + next};
    F scale[4];
    Spectrum<L> shape[4];
    for (int k = 0; k < 4; ++k) {
      F words[4];
      gather_row4<L>(map.spectra, node[k] << 2, words);
      shape[k] = evaluate(SigmoidPolynomial<L>{words[0], words[1], words[2]}, lambda);
      scale[k] = words[3];
    }
    const Spectrum<L> mixed{between(shape[0].c0, shape[1].c0, shape[2].c0, shape[3].c0),
                            between(shape[0].c1, shape[1].c1, shape[2].c1, shape[3].c1),
                            between(shape[0].c2, shape[1].c2, shape[2].c2, shape[3].c2),
                            between(shape[0].c3, shape[1].c3, shape[2].c3, shape[3].c3)};
    return mixed * between(scale[0], scale[1], scale[2], scale[3]);
  }
  const F unit(map.unit * 0x1p64f);
  F out[3];
  for (int c = 0; c < 3; ++c)
    out[c] = unit * between(nodes.radiance[0][c], nodes.radiance[1][c], nodes.radiance[2][c], nodes.radiance[3][c]);
  return {out[0], out[1], out[2], F(0.0f)};
}

/// Converts a density on the unit square to solid angle: the area element of the square is 2 pi^2 sin theta.
template <class F> SHEAF_INLINE F envmap_solid_angle_pdf(F density, F sin_theta) {
  const auto usable = sin_theta > F(0.0f);
  return select(usable, density * F(0.5f * kInvPi * kInvPi) / select(usable, sin_theta, F(1.0f)), F(0.0f));
}

/// Samples x in [0, 1] with a linear density proportional to `a` at 0 and `b` at 1, by inverting its CDF (Pharr et al.,
/// 4th ed., A.4.1, without cancellation).
template <class F> SHEAF_INLINE F sample_linear(F u, F a, F b) {
  const F root = sqrt(lerp(u, a * a, b * b));
  const F denominator = a + root;
  const auto usable = denominator > F(0.0f);
  return select(usable, clamp(u * (a + b) / select(usable, denominator, F(1.0f)), F(0.0f), F(1.0f)), u);
}

}  // namespace detail

/// Radiance from `direction` (unit length) and its pdf. Spectral mode: at `lambda`.
template <class L, ColorMode kMode = ColorMode::kRgb>
SHEAF_INLINE EnvmapValue<L> lookup_envmap(const EnvmapView& map, Vec3<L> direction, const Spectrum<L>& lambda = {}) {
  using F = Float<L>;
  using U = Uint<L>;
  const float* m = map.to_map;
  const F x = fma(F(m[0]), direction.x, fma(F(m[1]), direction.y, F(m[2]) * direction.z));
  const F y = fma(F(m[3]), direction.x, fma(F(m[4]), direction.y, F(m[5]) * direction.z));
  const F z = fma(F(m[6]), direction.x, fma(F(m[7]), direction.y, F(m[8]) * direction.z));
  const F sin_theta = sqrt(x * x + z * z);
  const F azimuth = atan2(x, -z) * F(0.5f * kInvPi);
  const F columns(static_cast<float>(map.width)), rows(static_cast<float>(map.height - 1));
  // floor(across), in [0, W], is the right node of the cell. The left node is one less (W - 1 for 0).
  const F across = clamp((azimuth - floor(azimuth)) * columns + F(0.5f), F(0.5f), columns + F(0.5f));
  const F down = clamp(atan2(sin_theta, y) * F(kInvPi), F(0.0f), F(1.0f)) * rows;
  const U after = to_uint(across);
  const detail::EnvmapCell<L> cell{select(after == U(0u), U(map.width - 1), after - U(1u)),
                                   min(to_uint(down), U(map.height - 2))};
  const detail::EnvmapCellPosition<L> at{across - to_float(after), down - to_float(cell.row)};
  const auto nodes = detail::load_nodes<L>(map, cell);
  return {detail::radiance_at<L, kMode>(map, nodes, cell, at, lambda),
          detail::envmap_solid_angle_pdf(detail::density_at<L>(nodes, at), sin_theta)};
}

namespace detail {

/// Prefetches rows[index] for each lane, and with `next` the row behind it.
template <class L, class Row> SHEAF_INLINE void prefetch(const Row* rows, typename L::Uint index, bool next) {
#if defined(__GNUC__)
  for (const std::uint32_t row : LaneArray<Uint<L>>(index)) {
    __builtin_prefetch(rows + row);
    if (next) __builtin_prefetch(rows + row + 1);
  }
#endif
}

}  // namespace detail

/// State of sampling a cell in two steps. The memory that a step reads depends on the result of the step before.
/// Callers that sample for many paths prefetch the next step's data and process other paths in the meantime.
template <class L> struct EnvmapDraw {
  QuantileDraw<L> row, column;
  typename L::Uint table;  ///< of the row's columns, in EnvmapView::quantiles
};

/// Step 1: samples a row by v in [0, 1), which determines the polar angle.
template <class L> SHEAF_INLINE EnvmapDraw<L> draw_envmap_row(const EnvmapView& map, Float<L> v) {
  EnvmapDraw<L> drawn;
  drawn.row = draw_quantile<L>(map.quantiles, Uint<L>(0u), v);
  drawn.table = gather(map.tables, drawn.row.quantile);
  return drawn;
}

/// Step 2: samples a column by u in [0, 1), which determines the longitude.
template <class L> SHEAF_INLINE void draw_envmap_column(const EnvmapView& map, Float<L> u, EnvmapDraw<L>& drawn) {
  drawn.column = draw_quantile<L>(map.quantiles, drawn.table, u);
}

/// Prefetches the data of draw_envmap_column().
template <class L>
SHEAF_INLINE void prefetch_envmap_column(const EnvmapView& map, Float<L> u, const EnvmapDraw<L>& drawn) {
  detail::prefetch<L>(map.quantiles, drawn.table + to_uint(u * Float<L>(static_cast<float>(kQuantiles))), false);
}

/// Prefetches the nodes that sample_envmap() reads.
template <class L> SHEAF_INLINE void prefetch_envmap_nodes(const EnvmapView& map, const EnvmapDraw<L>& drawn) {
  detail::prefetch<L>(map.columns, drawn.row.index * Uint<L>(map.width + 1) + drawn.column.index, true);
}

/// Samples a direction within a cell by the remainders of u and v. Both mappings are inversions, so stratification is
/// preserved. Spectral mode: radiance at `lambda`.
template <class L, ColorMode kMode = ColorMode::kRgb>
SHEAF_INLINE EnvmapSample<L> sample_envmap(const EnvmapView& map, const EnvmapDraw<L>& drawn,
                                           const Spectrum<L>& lambda = {}) {
  using F = Float<L>;
  const QuantileDraw<L>&row = drawn.row, &column = drawn.column;
  const detail::EnvmapCell<L> cell{column.index, row.index};
  const auto nodes = detail::load_nodes<L>(map, cell);
  const F* const b = nodes.brightness;
  const F of_row = gather(map.rows, row.index);
  const F of_column =
      nodes.density * F(1.0f / (static_cast<float>(map.width) * static_cast<float>(map.height - 1))) / of_row;
  detail::EnvmapCellPosition<L> at;
  // Sample the position in the cell.
  at.y = detail::sample_linear(row.remapped(of_row), b[0] + b[2], b[1] + b[3]);
  at.x = detail::sample_linear(column.remapped(of_column), lerp(at.y, b[0], b[1]), lerp(at.y, b[2], b[3]));

  // Convert to a direction in world space.
  const F across = (to_float(cell.column) + F(0.5f) + at.x) * F(1.0f / static_cast<float>(map.width));
  const F down = (to_float(cell.row) + at.y) * F(1.0f / static_cast<float>(map.height - 1));
  const auto longitude = sincos_2pi<L>(across - floor(across));
  const auto polar = sincos_2pi<L>(down * F(0.5f));
  const F sin_theta = max(polar.sin, F(0.0f));
  const Vec3<L> local{longitude.sin * sin_theta, polar.cos, -longitude.cos * sin_theta};
  const float* m = map.to_map;
  EnvmapSample<L> out;
  out.direction = {fma(F(m[0]), local.x, fma(F(m[3]), local.y, F(m[6]) * local.z)),
                   fma(F(m[1]), local.x, fma(F(m[4]), local.y, F(m[7]) * local.z)),
                   fma(F(m[2]), local.x, fma(F(m[5]), local.y, F(m[8]) * local.z))};
  out.radiance = detail::radiance_at<L, kMode>(map, nodes, cell, at, lambda);
  out.pdf_solid_angle = detail::envmap_solid_angle_pdf(detail::density_at<L>(nodes, at), sin_theta);
  return out;
}

/// Samples cell and direction by u and v.
template <class L, ColorMode kMode = ColorMode::kRgb>
SHEAF_INLINE EnvmapSample<L> sample_envmap(const EnvmapView& map, Float<L> u, Float<L> v,
                                           const Spectrum<L>& lambda = {}) {
  EnvmapDraw<L> drawn = draw_envmap_row<L>(map, v);
  draw_envmap_column<L>(map, u, drawn);
  return sample_envmap<L, kMode>(map, drawn, lambda);
}

}  // namespace sheaf

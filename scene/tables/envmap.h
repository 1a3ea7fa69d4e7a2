// Environment maps: radiance by direction from a picture, with tables to sample it in proportion to its brightness.
//
// Node (i, j) of W columns and H rows lies at u = (i + 1/2) / W, which goes round, and v = j / (H - 1) of the unit
// square; u is the longitude, atan2(x, -z) / 2 pi, and v the polar angle from +y, over pi, in the map's space. Radiance
// is bilinear in between. In spectral mode a node's radiance is a scale times a shape that is at most 1; each of the
// two is bilinear, and radiance their product, as scene files in Mitsuba's format are meant. Between nodes of one
// shape, so between greys, that is the same.
//
// Cell (i, j) lies between the nodes (i, j) and (i + 1, j + 1). Its probability is that of its row times that in a
// distribution over columns, which rows that share a quantile have in common (core/quantile_table.h): where much light
// comes from, cells are told apart, and elsewhere blocks of them. Inside of a cell the density goes with its nodes'
// brightness, again bilinear. Densities are exactly those of sampling.
#pragma once

#include "core/large_table.h"
#include "core/quantile_table.h"
#include "core/vec.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// Two nodes, (i, j) and (i, j + 1), and the cell between them and the next two: so a cell and its four nodes are two
/// rows of the table, 32 bytes in a row.
struct alignas(16) EnvmapColumn {
  /// Red, green and blue of the upper node, then of the lower one: see envmap_code().
  std::uint16_t radiance[6];
  float density;  ///< the cell's probability, per unit of the square; 0 for the column behind the last
};
static_assert(sizeof(EnvmapColumn) == 16);

/// Radiance in 16 bits: six of exponent, ten of mantissa, without a sign, which is a half float's precision and twice
/// its range; 0 is zero. Values are in units of the map's own and below 2; less than 2^-62 becomes 0.
std::uint16_t envmap_code(float value);

/// The value of a code, times 2^-64: its bits are those of a float, moved.
template <class L> SHEAF_INLINE Float<L> envmap_value(typename L::Uint code) { return bits_float(code << 13); }

/// How bright a node counts for density: luminance in units, less `offset`, from three values as envmap_value() has
/// them.
template <class L>
SHEAF_INLINE Float<L> envmap_brightness(typename L::Float r, typename L::Float g, typename L::Float b, float offset) {
  using F = typename L::Float;
  const F y = fma(r, F(0.2126f * 0x1p64f), fma(g, F(0.7152f * 0x1p64f), b * F(0.0722f * 0x1p64f)));
  return max(y - F(offset), F(0.0f));
}

/// What kernels see of an environment map.
struct EnvmapView {
  const EnvmapColumn* columns = nullptr;  ///< H - 1 rows of W + 1; the last of a row repeats the nodes of its first
  /// Spectral mode: c0, c1, c2 and scale of each node's ScaledSigmoid, to be multiplied by D65. Row by row from +y.
  const float* spectra = nullptr;
  const Quantile* quantiles = nullptr;    ///< of the H - 1 rows of cells, then tables of W columns
  const float* rows = nullptr;            ///< probabilities of the H - 1 rows of cells
  const std::uint32_t* tables = nullptr;  ///< for each quantile of rows, where its columns' begin
  std::uint32_t width = 0, height = 0;    ///< W >= 1, H >= 2
  float unit = 1;                         ///< radiance of a unit of envmap_code(), W / (m^2 sr)
  float offset = 0;                       ///< see envmap_brightness()
  float to_map[9] = {};                   ///< rows of the orthogonal matrix from world space
};

/// Owns the tables of an environment map.
struct Envmap {
  LargeTable<EnvmapColumn> columns;
  LargeTable<float> spectra;
  LargeTable<Quantile> quantiles;
  std::vector<std::uint32_t> tables;
  std::vector<float> rows;
  std::uint32_t width = 0, height = 0;
  float unit = 1, offset = 0;
  float to_map[9] = {};
  Vec3f mean{};  ///< radiance averaged over all directions; zero: the map is black, or there is none

  EnvmapView view() const;
  std::size_t bytes() const {
    return columns.capacity() * sizeof(EnvmapColumn) + spectra.capacity() * sizeof(float) +
           quantiles.capacity() * sizeof(Quantile) + tables.capacity() * sizeof(std::uint32_t) +
           rows.capacity() * sizeof(float);
  }
};

}  // namespace sheaf

// Environment maps: radiance by direction from an image, with tables for importance sampling by brightness (PBR 12.5).
//
// Node (i, j) of W columns and H rows lies at u = (i + 1/2) / W, which is periodic, and v = j / (H - 1) of the unit
// square. In the map's space, u is the longitude atan2(x, -z) / 2 pi, and v is the polar angle from +y, over pi.
// Radiance is bilinear between nodes. In spectral mode a node's radiance is a scale times a shape that is at most 1.
// Scale and shape are each bilinear, and radiance is their product, as in Mitsuba. The two agree between nodes of the
// same shape, for example grays.
//
// Cell (i, j) lies between the nodes (i, j) and (i + 1, j + 1). Its probability is that of its row times that in a
// distribution over columns, which is shared by the rows of a quantile (core/sampling/quantile_table.h). Bright regions
// are resolved into single cells, and other regions into blocks of them. Inside a cell the density is bilinear in the
// brightness of its nodes. Pdfs are exactly those of sampling.
#pragma once

#include "core/math/vec.h"
#include "core/sampling/quantile_table.h"
#include "core/soa/large_table.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// The nodes (i, j) and (i, j + 1), and the cell to their right. A cell and its four nodes are two consecutive rows of
/// the table, 32 bytes.
struct alignas(16) EnvmapColumn {
  /// RGB of the upper node, then of the lower one; see envmap_code()
  std::uint16_t radiance[6];
  float density;  ///< the cell's probability density on the unit square; 0 for the column after the last
};
static_assert(sizeof(EnvmapColumn) == 16);

/// Encodes radiance in 16 bits without a sign: 6 bits of exponent, 10 of mantissa, the precision of a half float with
/// twice the range of exponents. 0 is zero. Values are in units of the map and below 2; values below 2^-62 become 0.
std::uint16_t envmap_code(float value);

/// Decodes a value, times 2^-64: the code is shifted into the bits of a float.
template <class L> SHEAF_INLINE Float<L> envmap_value(typename L::Uint code) { return bits_float(code << 13); }

/// Brightness of a node for sampling: luminance in units of the map, minus `offset` and clamped to 0. Inputs are values
/// of envmap_value().
template <class L>
SHEAF_INLINE Float<L> envmap_brightness(typename L::Float r, typename L::Float g, typename L::Float b, float offset) {
  using F = typename L::Float;
  const F y = fma(r, F(0.2126f * 0x1p64f), fma(g, F(0.7152f * 0x1p64f), b * F(0.0722f * 0x1p64f)));
  return max(y - F(offset), F(0.0f));
}

/// Environment map for kernels.
struct EnvmapView {
  /// H - 1 rows of W + 1 columns; the last of a row repeats the nodes of the first
  const EnvmapColumn* columns = nullptr;
  /// Spectral mode: c0, c1, c2 and scale of each node's ScaledSigmoid, to be multiplied by D65. Row by row from +y.
  const float* spectra = nullptr;
  const Quantile* quantiles = nullptr;    ///< for the H - 1 rows of cells, then tables of W columns
  const float* rows = nullptr;            ///< probabilities of the H - 1 rows of cells
  const std::uint32_t* tables = nullptr;  ///< for each quantile of rows, the start of its table of columns
  std::uint32_t width = 0, height = 0;    ///< W >= 1, H >= 2
  float unit = 1;                         ///< radiance of one unit of envmap_code(), W / (m^2 sr)
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
  Vec3f mean{};  ///< radiance averaged over all directions; zero: black or no map

  EnvmapView view() const;
  std::size_t bytes() const {
    return columns.capacity() * sizeof(EnvmapColumn) + spectra.capacity() * sizeof(float) +
           quantiles.capacity() * sizeof(Quantile) + tables.capacity() * sizeof(std::uint32_t) +
           rows.capacity() * sizeof(float);
  }
};

}  // namespace sheaf

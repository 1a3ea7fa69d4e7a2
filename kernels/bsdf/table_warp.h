// Functions on the unit square, tabulated on a grid and interpolated bilinearly. There is a grid (slice) for each value
// of one or two parameters, and slices are mixed linearly in the parameters. Densities are sampled exactly: rows by
// their marginal, then columns by their conditional density, each by inverting an integral that is quadratic within a
// cell. All integrals are linear in the values, so the integrals of a mixture are the mixture of the slices' integrals
// (Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering", 2018, section
// 4.2).
#pragma once

#include "core/math/vec.h"
#include "core/soa/find_interval.h"

namespace sheaf {

/// Two neighboring indices and the interpolation weight between them.
template <class L> struct Neighbors {
  Uint<L> low, high;
  Float<L> t;
};

/// Locates `x` among `count` increasing numbers that start at tables[first]. Values outside are clamped to the ends.
template <class L>
SHEAF_INLINE Neighbors<L> find_neighbors(const float* tables, Uint<L> first, Uint<L> count, Float<L> x) {
  using F = Float<L>;
  using U = Uint<L>;
  const U low = find_interval<L>(count, [&](U i) SHEAF_LAMBDA_INLINE { return gather(tables, first + i) <= x; });
  const U high = min(low + U(1u), count - U(1u));
  const F a = gather(tables, first + low), b = gather(tables, first + high);
  const auto apart = b > a;
  return {low, high, select(apart, clamp((x - a) / select(apart, b - a, F(1.0f)), F(0.0f), F(1.0f)), F(0.0f))};
}

/// Up to four slices and their weights, which sum to 1.
template <class L> struct SliceMix {
  Uint<L> slice[4];
  Float<L> weight[4];
  int count;  ///< number of slices that have a weight in any lane

  /// The slices around a point in two parameters; the inner parameter varies fastest.
  SHEAF_INLINE SliceMix(const Neighbors<L>& outer, const Neighbors<L>& inner, Uint<L> inner_count) {
    const Float<L> one(1.0f);
    slice[0] = outer.low * inner_count + inner.low, slice[1] = outer.low * inner_count + inner.high;
    slice[2] = outer.high * inner_count + inner.low, slice[3] = outer.high * inner_count + inner.high;
    weight[0] = (one - outer.t) * (one - inner.t), weight[1] = (one - outer.t) * inner.t;
    weight[2] = outer.t * (one - inner.t), weight[3] = outer.t * inner.t;
    count = any(outer.t > Float<L>(0.0f)) ? 4 : 2;
  }
};

/// A grid cell and the position within it, in [0, 1]^2.
template <class L> struct TableCell {
  Uint<L> corner;  ///< index of its first value
  Uint<L> row;
  Float<L> x, y;
};

/// Values on a grid of `width` times `height` points, x fastest, of a mixture of slices that are `stride` floats apart.
template <class L> struct TableGrid {
  using F = typename L::Float;
  using U = typename L::Uint;
  const float* tables;
  U width, height;
  SliceMix<L> mix;
  U first[4];  ///< index of each slice's first float

  SHEAF_INLINE TableGrid(const float* tables_in, U begin, U stride, U width_in, U height_in, const SliceMix<L>& mix_in)
      : tables(tables_in), width(width_in), height(height_in), mix(mix_in) {
    for (int k = 0; k < mix.count; ++k) first[k] = begin + mix.slice[k] * stride;
  }

  /// Float `i` of the mixed slices.
  SHEAF_INLINE F at(U i) const {
    F sum = mix.weight[0] * gather(tables, first[0] + i);
    for (int k = 1; k < mix.count; ++k) sum = fma(mix.weight[k], gather(tables, first[k] + i), sum);
    return sum;
  }

  SHEAF_INLINE TableCell<L> cell(F x, F y) const {
    const U last_column = width - U(2u), last_row = height - U(2u);
    const F position_x = clamp(x, F(0.0f), F(1.0f)) * to_float(width - U(1u));
    const F position_y = clamp(y, F(0.0f), F(1.0f)) * to_float(height - U(1u));
    const U column = min(to_uint(position_x), last_column), row = min(to_uint(position_y), last_row);
    return {row * width + column, row, position_x - to_float(column), position_y - to_float(row)};
  }

  /// Bilinear value in the cell, of the grid that begins `offset` floats into each slice.
  SHEAF_INLINE F interpolate(const TableCell<L>& c, U offset) const {
    const U corner = c.corner + offset;
    return lerp(c.y, lerp(c.x, at(corner), at(corner + U(1u))),
                lerp(c.x, at(corner + width), at(corner + width + U(1u))));
  }
};

/// A density on the unit square. Each slice stores its values, then the integral along x up to each value, then the
/// integral of all up to each row; the last of these is 1.
template <class L> struct TableWarp : TableGrid<L> {
  using F = typename L::Float;
  using U = typename L::Uint;

  /// Number of floats per slice.
  static SHEAF_INLINE U stride(U width, U height) { return width * height * U(2u) + height; }

  SHEAF_INLINE TableWarp(const float* tables_in, U begin, U width_in, U height_in, const SliceMix<L>& mix_in)
      : TableGrid<L>(tables_in, begin, stride(width_in, height_in), width_in, height_in, mix_in) {}

  struct Point {
    F x, y;
    F pdf;  ///< per area of the square
  };

  /// Maps the random numbers u and v to a point with this density.
  SHEAF_INLINE Point sample(F u, F v) const {
    // Sample y from the marginal density of the rows
    const U row =
        find_interval<L>(this->height, [&](U i) SHEAF_LAMBDA_INLINE { return this->at(marginal() + i) <= v; });
    const U end = conditional() + row * this->width + this->width - U(1u);
    const F low_total = this->at(end), high_total = this->at(end + this->width);
    const F y = solve(low_total, high_total, v - this->at(marginal() + row));
    // Sample x from the conditional density within the row
    const F left = u * lerp(y, low_total, high_total);
    const U line = conditional() + row * this->width;
    const auto up_to = [&](U i) SHEAF_LAMBDA_INLINE {
      return lerp(y, this->at(line + i), this->at(line + this->width + i));
    };
    const U column = find_interval<L>(this->width, [&](U i) SHEAF_LAMBDA_INLINE { return up_to(i) <= left; });
    const U corner = row * this->width + column;
    const F a = lerp(y, this->at(corner), this->at(corner + this->width));
    const F b = lerp(y, this->at(corner + U(1u)), this->at(corner + this->width + U(1u)));
    const F x = solve(a, b, left - up_to(column));
    return {(to_float(column) + x) / to_float(this->width - U(1u)),
            (to_float(row) + y) / to_float(this->height - U(1u)), lerp(x, a, b) * cells()};
  }

  /// Inverse of sample(): the random numbers that map to this point, and its density.
  SHEAF_INLINE Point invert(F x, F y) const {
    const TableCell<L> c = this->cell(x, y);
    const F a = lerp(c.y, this->at(c.corner), this->at(c.corner + this->width));
    const F b = lerp(c.y, this->at(c.corner + U(1u)), this->at(c.corner + this->width + U(1u)));
    const U line = conditional() + c.corner, end = conditional() + c.row * this->width + this->width - U(1u);
    // Integrate within the row up to x, and over the rows up to y
    const F left = fma(c.x, fma(F(0.5f) * c.x, b - a, a), lerp(c.y, this->at(line), this->at(line + this->width)));
    const F low_total = this->at(end), high_total = this->at(end + this->width);
    const F below = fma(c.y, fma(F(0.5f) * c.y, high_total - low_total, low_total), this->at(marginal() + c.row));
    const F total = max(lerp(c.y, low_total, high_total), F(1e-30f));
    return {min(left / total, F(1.0f)), min(below, F(1.0f)), lerp(c.x, a, b) * cells()};
  }

  SHEAF_INLINE F pdf(F x, F y) const { return this->interpolate(this->cell(x, y), U(0u)) * cells(); }

 private:
  SHEAF_INLINE U conditional() const { return this->width * this->height; }
  SHEAF_INLINE U marginal() const { return conditional() * U(2u); }
  SHEAF_INLINE F cells() const { return to_float(this->width - U(1u)) * to_float(this->height - U(1u)); }

  /// Position in [0, 1] at which the integral of a linear density from a to b reaches `area`.
  static SHEAF_INLINE F solve(F a, F b, F area) {
    const F twice = F(2.0f) * max(area, F(0.0f));
    const F root = sqrt(max(fma(a, a, twice * (b - a)), F(0.0f)));
    return clamp(twice / max(a + root, F(1e-30f)), F(0.0f), F(1.0f));
  }
};

}  // namespace sheaf

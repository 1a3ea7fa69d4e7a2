// Surface interaction of signed distance grids, generic in the lane policy.
#pragma once

#include "scene/surfaces/surface.h"

namespace sheaf {

namespace detail {

/// The cell that was hit.
template <class L> struct SdfCell {
  typename L::Float value[8];  ///< values at the corners, in the order x + 2 y + 4 z
  typename L::Uint corner[3];  ///< index of its minimum corner along each axis
  typename L::Uint first;      ///< index of that corner in GeometryView::sdf_values
  typename L::Uint step[3];    ///< stride in sdf_values along each axis; 0 in inactive lanes
};

/// Bilinear interpolation of the values at (0, 0), (1, 0), (0, 1) and (1, 1).
template <class F> SHEAF_INLINE F mix4(F a, F b, F c, F d, F s, F t) { return lerp(t, lerp(s, a, b), lerp(s, c, d)); }

/// The trilinear function in a cell, and its gradient.
template <class L> SHEAF_INLINE typename L::Float cell_value(const typename L::Float* v, Vec3<L> x) {
  return lerp(x.z, mix4(v[0], v[1], v[2], v[3], x.x, x.y), mix4(v[4], v[5], v[6], v[7], x.x, x.y));
}
template <class L> SHEAF_INLINE Vec3<L> cell_gradient(const typename L::Float* v, Vec3<L> x) {
  return {mix4(v[1] - v[0], v[3] - v[2], v[5] - v[4], v[7] - v[6], x.y, x.z),
          mix4(v[2] - v[0], v[3] - v[1], v[6] - v[4], v[7] - v[5], x.x, x.z),
          mix4(v[4] - v[0], v[5] - v[1], v[6] - v[2], v[7] - v[3], x.x, x.y)};
}

template <class L>
SHEAF_INLINE SdfCell<L> sdf_cell(const SceneView& scene, const SdfGridRecord<L>& grid, Mask<L> active,
                                 typename L::Uint primitive) {
  using U = typename L::Uint;
  const U zero(0u), words = select(active, (grid.first_cell + primitive) << 1, zero);
  const U xy = gather(scene.geometry.sdf_cells, words), z = gather(scene.geometry.sdf_cells, words + U(1u));
  SdfCell<L> cell;
  cell.corner[0] = xy & U(0xffffu);
  cell.corner[1] = xy >> 16;
  cell.corner[2] = z;
  cell.step[0] = select(active, U(1u), zero);
  cell.step[1] = select(active, grid.size_x, zero);
  cell.step[2] = select(active, grid.layer, zero);
  cell.first = select(active, grid.first_value, zero) + cell.step[0] * cell.corner[0] + cell.step[1] * cell.corner[1] +
               cell.step[2] * cell.corner[2];
  for (int i = 0; i < 8; ++i) {
    U at = cell.first;
    for (int axis = 0; axis < 3; ++axis)
      if ((i >> axis & 1) != 0) at = at + cell.step[axis];
    cell.value[i] = gather(scene.geometry.sdf_values, at);
  }
  return cell;
}

/// Slopes along one axis at the point: in the cell, and in its neighbor on the point's side; with the weight of the
/// cell.
template <class L> struct AxisSlopes { typename L::Float own, other, own_weight; };

template <class L>
SHEAF_INLINE AxisSlopes<L> axis_slopes(const SceneView& scene, const SdfCell<L>& cell, const typename L::Uint* size,
                                       int axis, const typename L::Float* x) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const int across = (axis + 1) % 3, along = (axis + 2) % 3, bit = 1 << axis, b = 1 << across, c = 1 << along;
  const F* v = cell.value;
  const F low = mix4(v[0], v[b], v[c], v[b + c], x[across], x[along]);
  const F high = mix4(v[bit], v[bit + b], v[bit + c], v[bit + b + c], x[across], x[along]);
  const U zero(0u), one(1u);
  const auto upper = x[axis] >= F(0.5f);
  const auto there =
      select(upper, cell.corner[axis] + U(2u), cell.corner[axis]) - select(upper, zero, one) < size[axis];
  // Without a neighbor, the cell's own values are read.
  const U beyond =
      cell.first + select(upper, cell.step[axis] + cell.step[axis], zero) - select(upper, zero, cell.step[axis]);
  const U from = select(there, beyond, cell.first);
  const F outer =
      mix4(gather(scene.geometry.sdf_values, from), gather(scene.geometry.sdf_values, from + cell.step[across]),
           gather(scene.geometry.sdf_values, from + cell.step[along]),
           gather(scene.geometry.sdf_values, from + cell.step[across] + cell.step[along]), x[across], x[along]);
  const F scale = to_float(size[axis] - one);
  const F fraction = F(1.0f) - abs(x[axis] - F(0.5f));
  return {(high - low) * scale, select(upper, outer - high, low - outer) * scale, select(there, fraction, F(1.0f))};
}

/// The continuous normal of Hansson-Soederlund, Evans and Akenine-Moeller 2022. It interpolates the normals of the
/// eight cells around the nearest grid point between the centers of these cells. In the space in which the grid is the
/// unit cube; not normalized.
template <class L>
SHEAF_INLINE Vec3<L> smooth_sdf_normal(const SceneView& scene, const SdfGridRecord<L>& grid, const SdfCell<L>& cell,
                                       Vec3<L> x) {
  using F = typename L::Float;
  const typename L::Uint size[3] = {grid.size_x, grid.size_y, grid.size_z};
  const F at[3] = {clamp(x.x, F(0.0f), F(1.0f)), clamp(x.y, F(0.0f), F(1.0f)), clamp(x.z, F(0.0f), F(1.0f))};
  AxisSlopes<L> axis[3];
  for (int k = 0; k < 3; ++k) axis[k] = axis_slopes<L>(scene, cell, size, k, at);
  Vec3<L> sum{F(0.0f), F(0.0f), F(0.0f)};
  for (int i = 0; i < 8; ++i) {
    F slope[3], fraction(1.0f);
    for (int k = 0; k < 3; ++k) {
      const bool other = (i >> k & 1) != 0;
      slope[k] = other ? axis[k].other : axis[k].own;
      fraction = fraction * (other ? F(1.0f) - axis[k].own_weight : axis[k].own_weight);
    }
    const Vec3<L> n{slope[0], slope[1], slope[2]};
    sum = sum + n * (fraction / max(length(n), F(1e-30f)));
  }
  return sum;
}

}  // namespace detail

/// Surface point of a signed distance grid near `hit`, found by two Newton steps along the gradient. uv are 0 and the
/// tangents arbitrary. Not inlined: such grids are rare.
template <class L, bool kWithUv>
[[gnu::noinline]] SurfacePoint<L> sdf_point(const SceneView& scene, const ShapeRecord<L>& shape, Mask<L> active,
                                            Uint<L> primitive, Vec3<L> hit) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const U zero(0u);
  const QuadricRecord<L> q = gather_rows<L>(scene.geometry.quadrics, select(active, shape.first_triangle, zero));
  const SdfGridRecord<L> grid = gather_rows<L>(scene.geometry.sdf_grids, select(active, shape.first_vertex, zero));
  const detail::SdfCell<L> cell = detail::sdf_cell<L>(scene, grid, active, primitive);
  const Vec3<L> corner{to_float(cell.corner[0]), to_float(cell.corner[1]), to_float(cell.corner[2])};
  const F half(0.5f);
  const auto near_cell = [&](F a) SHEAF_LAMBDA_INLINE { return clamp(a, F(-half), F(1.0f) + half); };
  Vec3<L> x = q.object_point(hit) - corner;
  x = {near_cell(x.x), near_cell(x.y), near_cell(x.z)};
  Vec3<L> gradient = detail::cell_gradient<L>(cell.value, x);
  for (int step = 0; step < 2; ++step) {
    const F by = detail::cell_value<L>(cell.value, x) / max(dot(gradient, gradient), F(1e-30f));
    const F longest = half / max(max_component(abs(gradient)), F(1e-30f));
    x = x - gradient * clamp(by, -longest, longest);
    gradient = detail::cell_gradient<L>(cell.value, x);
  }
  SurfacePoint<L> out;
  const Vec3<L> position = x + corner;
  out.p = q.world_point(position);
  const Vec3<L> slope = q.world_normal(gradient);
  out.ng = normalize_any(slope) * q.normal_sign;
  out.ns = out.ng;
  const auto smooth = active & (grid.smooth != zero);
  if (any(smooth)) {
    const Vec3<L> n = detail::smooth_sdf_normal<L>(scene, grid, cell, x);
    const Vec3<L> inner{n.x / to_float(grid.size_x - U(1u)), n.y / to_float(grid.size_y - U(1u)),
                        n.z / to_float(grid.size_z - U(1u))};
    const auto usable = smooth & (max_component(abs(inner)) > F(1e-20f));
    out.ns = select<L>(usable, normalize_any(q.world_normal(inner)) * q.normal_sign, out.ng);
  }
  F extent(0.0f), width(0.0f), largest(0.0f);
  for (int row = 0; row < 12; row += 4) {
    const F* m = q.to_world + row;
    extent = max(extent, abs(m[0] * position.x) + abs(m[1] * position.y) + abs(m[2] * position.z) + abs(m[3]));
    width = max(width, abs(m[0]) + abs(m[1]) + abs(m[2]));
  }
  for (const F& value : cell.value) largest = max(largest, abs(value));
  // Rounding errors of the position and of the value at the root.
  const F in_value = min(largest / max(length(slope), F(1e-30f)), F(1e3f) * width);
  out.offset = F(kOffsetUlps) * (extent + width + in_value);
  if constexpr (kWithUv) {
    const auto frame = Frame<L>::from_normal(out.ng);
    out.uv = {F(0.0f), F(0.0f)};
    out.dp_du = frame.s;
    out.dp_dv = frame.t;
    out.squared_uv_lengths = {F(kInfinity), F(kInfinity)};
  }
  return out;
}

}  // namespace sheaf

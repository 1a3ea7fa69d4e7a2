// Color grids in spectral mode: each voxel is a spectrum, stored as a shape and a scale.
//
// Shapes and scales are interpolated separately and then multiplied, as in Mitsuba 3's spectral variants. Halfway
// between a bright and a dark color, this differs from the spectrum of the interpolated color.
#pragma once

#include "core/color/float4.h"
#include "core/color/uplift.h"
#include "scene/tables/brick_grid_lookup.h"

namespace sheaf {

/// An unbounded color as the sigmoid coefficients of a shape, whose largest component is kUpliftUnbounded, and a
/// scale. Replaces the color in a voxel.
struct VoxelSpectrum {
  float c0, c1, c2, scale;
};

inline VoxelSpectrum voxel_spectrum(const UpliftTable& table, Vec3f rgb) {
  rgb = {max(rgb.x, 0.0f), max(rgb.y, 0.0f), max(rgb.z, 0.0f)};
  // The shape of grays is 1/2 at all wavelengths.
  if (rgb.x == rgb.y && rgb.y == rgb.z) return {0, 0, 0, rgb.x / kUpliftUnbounded};
  const ScaledSigmoid<Scalar> s = uplift_unbounded<Scalar>(table, rgb);
  return {s.shape.c0, s.shape.c1, s.shape.c2, s.scale};
}

/// Replaces the colors of a three-channel grid by spectra.
inline void uplift_grid(BrickGrid& grid) {
  const UpliftTable& table = UpliftTable::get();
  for (std::size_t i = 0; i + kColorVoxel <= grid.values.size(); i += kColorVoxel) {
    float* v = grid.values.data() + i;
    const VoxelSpectrum spectrum = voxel_spectrum(table, {v[0], v[1], v[2]});
    v[0] = spectrum.c0, v[1] = spectrum.c1, v[2] = spectrum.c2, v[3] = spectrum.scale;
  }
}

namespace detail {

/// sigmoid() of core/color/sigmoid_polynomial.h at the normalized wavelengths `t`.
SHEAF_INLINE Float4 shape_at(const float* voxel, Float4 t) {
  const Float4 x = (Float4(voxel[0]) * t + Float4(voxel[1])) * t + Float4(voxel[2]);
  return Float4(0.5f) + Float4(0.5f) * x / sqrt(x * x + Float4(1.0f));
}

}  // namespace detail

/// Value of a grid after uplift_grid(), at a world-space point and four wavelengths in nm.
inline Float4 lookup_grid_spectrum(const BrickGridRow& row, Vec3f p, const Spectrum4& lambda) {
  using namespace detail;
  const Float4 t = (Float4(lambda) - Float4(kSigmoidCenter)) * (1.0f / kSigmoidHalfRange);
  // Outside of the grid, use the background
  GridCell cell;
  if (!find_grid_cell(row, p, kColorVoxel, cell)) {
    const Vec3f outside{row.background[0], row.background[1], row.background[2]};
    if (!(max_component(outside) > 0.0f)) return Float4();
    const VoxelSpectrum s = voxel_spectrum(UpliftTable::get(), outside);
    return shape_at(&s.c0, t) * s.scale;
  }
  if (row.nearest) return shape_at(cell.voxel, t) * cell.voxel[3];
  // Interpolate shape and scale
  Float4 shape;
  float scale = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool x = (corner & 1) != 0, y = (corner & 2) != 0, z = (corner & 4) != 0;
    const float weight =
        (x ? cell.tx : 1.0f - cell.tx) * (y ? cell.ty : 1.0f - cell.ty) * (z ? cell.tz : 1.0f - cell.tz);
    if (weight == 0.0f) continue;
    const float* v =
        cell.voxel + ((z ? kBrickStride * kBrickStride : 0) + (y ? kBrickStride : 0) + (x ? 1 : 0)) * kColorVoxel;
    shape = shape + shape_at(v, t) * weight;
    scale += v[3] * weight;
  }
  return shape * scale;
}

}  // namespace sheaf

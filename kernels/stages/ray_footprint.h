// The footprint of a path at a surface: the part of the surface that one sample stands for, over which textures average
// colors. Rays are cones (Akenine-Moller et al. 2021, "Improved Shader and Texture Level of Detail Using Ray Cones").
//
// Those of sample i of a pixel are narrower by 1 / sqrt(i + 1): i + 1 of them together are as wide as the pixel, as the
// samples so far share it. Images then converge to those without footprints, and depend on no number of samples.
//
// The state of a path has no cone. A ray that a rough surface or a medium scattered starts at a point, with a spread
// from the pdf of its direction. After a delta lobe, it starts at a point with the spread of a pixel. Both cones are
// narrower than those that start with the width of the last one, which curved surfaces may have focused.
#pragma once

#include "kernels/wave/wave.h"
#include "scene/surfaces/surface.h"

namespace sheaf {

/// Width of the cone around a sampled direction, of the width of the cone of solid angle 1 / pdf. Small, as the
/// textures of atlases continue with others.
inline constexpr float kScatteredFootprint = 1.0f / 16;

/// Whether textures are looked up with footprints. Only on camera paths: connections from lights have no pixel yet.
inline bool has_footprints(const StageContext& context) {
  return context.scene.textures.has_mip_levels && context.pass() == PassKind::kPath;
}

/// See TextureQuery.
template <class L> struct RayFootprint {
  Vec2<L> squared_lengths{typename L::Float(0.0f), typename L::Float(0.0f)};
  Vec2<L> axis{typename L::Float(0.0f), typename L::Float(0.0f)};
};

/// The vector of the uv plane along which a cone of the given width stretches where it hits a surface at an angle.
template <class L> SHEAF_INLINE Vec2<L> footprint_axis(const SurfacePoint<L>& y, Vec3<L> direction, Float<L> width) {
  using F = Float<L>;
  const F along_normal = dot(direction, y.ng), cosine = max(abs(along_normal), F(1.0f / 64));
  // From the width to the width over the cosine
  const Vec3<L> axis = (direction - y.ng * along_normal) * (width / (cosine * (F(1.0f) + cosine)));
  // Its coordinates by the unit vectors along u and v
  const F u_length = length(y.dp_du), v_length = length(y.dp_dv);
  const F u = dot(axis, y.dp_du) / u_length, v = dot(axis, y.dp_dv) / v_length;
  const F skew = dot(y.dp_du, y.dp_dv) / (u_length * v_length), determinant = F(1.0f) - skew * skew;
  const auto usable = determinant > F(1e-3f);
  const F scale = select(usable, F(1.0f) / select(usable, determinant, F(1.0f)), F(0.0f));
  return {(u - skew * v) * scale / sqrt(y.squared_uv_lengths.x), (v - skew * u) * scale / sqrt(y.squared_uv_lengths.y)};
}

/// The footprint at hits.
template <class L>
SHEAF_INLINE RayFootprint<L> ray_footprint(const StageContext& context, const Wave& wave, const Slot* slots,
                                           const RayState<L>& ray, Float<L> distance, const SurfacePoint<L>& y) {
  using F = Float<L>;
  using U = Uint<L>;
  if (!has_footprints(context)) return {};
  const PixelCone& pixel = context.scene.sensor.pixel_cone;
  const F pdf = wave.radiance.gather<L>(slots).scatter_pdf, sample = to_float(wave.paths.gather<L>(slots).sample);
  const auto spreads = pdf > F(0.0f), from_camera = (ray.flags & U(kRayFromCamera)) != U(0u);
  const F width = fma(distance, F(pixel.spread), select(from_camera, F(pixel.width), F(0.0f)));
  // Four over pi: the squared diameter of a disk of area 1
  const F scattered = distance * distance * F(4.0f * kInvPi * kScatteredFootprint * kScatteredFootprint);
  const F squared = select(spreads, scattered / select(spreads, pdf, F(1.0f)), width * width) / (sample + F(1.0f));
  RayFootprint<L> out;
  out.squared_lengths = {squared / y.squared_uv_lengths.x, squared / y.squared_uv_lengths.y};
  if (!all(spreads)) out.axis = footprint_axis<L>(y, ray.direction, select(spreads, F(0.0f), sqrt(squared)));
  return out;
}

}  // namespace sheaf

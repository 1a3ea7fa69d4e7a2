// Emissive media as lights: points are sampled in proportion to the emission.
//
// A volume light is an axis-aligned box divided into cells. A cell is chosen in proportion to its emission, a point in
// it uniformly. Points in the box that lie outside the medium contribute nothing; the ray to or from them detects this
// (kernels/stages/transmittance.cpp; PhotonEmission::medium).
#pragma once

#include "core/sampling/alias_table.h"
#include "kernels/lights/light_kind.h"
#include "scene/lights/volume_light.h"
#include "scene/tables/medium_lookup.h"
#include "scene/tables/motion_sample.h"

namespace sheaf {

/// Pdf, per cubic meter, of sampling the point `p` of a volume light.
inline float volume_light_pdf(const SceneView& scene, std::uint32_t index, Vec3f p) {
  const VolumeLightData<Scalar> light = scene.lights.rows[index].data<VolumeLightData>();
  const VolumeCells cells = VolumeCells::of_word(light.cells);
  const Vec3f size = light.extent;
  const auto cell_of = [](float x, float lower, float extent, std::uint32_t count) {
    const float at = (x - lower) / extent * static_cast<float>(count);
    return at >= 0.0f && at <= static_cast<float>(count) ? std::min(to_uint(at), count - 1u) : kNone;
  };
  const std::uint32_t x = cell_of(p.x, light.corner.x, size.x, cells.x);
  const std::uint32_t y = cell_of(p.y, light.corner.y, size.y, cells.y);
  const std::uint32_t z = cell_of(p.z, light.corner.z, size.z, cells.z);
  if (x == kNone || y == kNone || z == kNone) return 0.0f;
  const AliasEntry& cell = scene.lights.triangle_alias[light.first_cell + (z * cells.y + y) * cells.x + x];
  return cell.pdf * static_cast<float>(cells.count()) / (size.x * size.y * size.z);
}

/// The same for the point `p` of world space at a time in [0, 1], wherever the light is then.
inline float volume_light_pdf_at(const SceneView& scene, std::uint32_t index, Vec3f p, float time) {
  if (scene.motion.lights == nullptr || scene.motion.lights[index].segment_count == 0)
    return volume_light_pdf(scene, index, p);
  const InstancePlacement<Scalar> placed = sample_motion<Scalar>(scene.motion, scene.motion.lights[index], time).placed;
  return volume_light_pdf(scene, index, placed.object_point(p)) / std::fabs(placed.determinant);
}

/// A point of a volume light.
template <class L> struct VolumePoint {
  Vec3<L> p;
  typename L::Float pdf_volume;  ///< per cubic meter
  Spectrum<L> emitted;           ///< sigma_a times the emitted radiance, W / (m^3 sr)
  static constexpr auto fields(auto& s) { return std::tie(s.p, s.pdf_volume, s.emitted); }
};

/// Samples a point by u.y, u.z and u.w. `lambda`: the path's wavelengths; unused in RGB mode.
inline VolumePoint<Scalar> sample_volume_light(const SceneView& scene, std::uint32_t index, const Random4<Scalar>& u,
                                               const Spectrum4& lambda) {
  const VolumeLightData<Scalar> light = scene.lights.rows[index].data<VolumeLightData>();
  const VolumeCells cells = VolumeCells::of_word(light.cells);
  const Vec3f size = light.extent;
  const auto cell = sample_alias<Scalar>(scene.lights.triangle_alias, light.first_cell, cells.count(), u.w);
  // The remainder of u.w depends on the cell, so the third coordinate uses a hash of its bits instead.
  std::uint32_t a = float_bits(u.w), b = float_bits(u.y), c = float_bits(u.z), d = index;
  hash4(a, b, c, d);
  const float depth = cells.count() == 1 ? u.w : unit_float(a ^ b);
  const std::uint32_t x = cell.index % cells.x, y = cell.index / cells.x % cells.y, z = cell.index / cells.x / cells.y;
  VolumePoint<Scalar> out;
  out.p = {light.corner.x + size.x * ((static_cast<float>(x) + u.y) / static_cast<float>(cells.x)),
           light.corner.y + size.y * ((static_cast<float>(y) + u.z) / static_cast<float>(cells.y)),
           light.corner.z + size.z * ((static_cast<float>(z) + depth) / static_cast<float>(cells.z))};
  out.pdf_volume = cell.pdf * static_cast<float>(cells.count()) / (size.x * size.y * size.z);
  // Evaluate the emission.
  const MediumRow& medium = scene.media.rows[light.medium];
  const MediumSpectra spectra = medium_spectra(scene, medium, lambda);
  out.emitted = to_spectrum(medium_coefficients(scene, medium, spectra, out.p, lambda).sigma_a *
                            medium_emission(scene, medium, spectra, out.p, lambda));
  return out;
}

struct VolumeLight {
  using Kind = VolumeLightKind;
  static constexpr LightHitKind kHitKind = LightHitKind::kMedium;

  /// `radiance` of the sample is per meter.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE LightSample<L> sample(const LightQuery<L>& lights, Vec3<L> from, const Random4<L>& u,
                                            TextureQuery<L>&) {
    using F = Float<L>;
    const VolumePoint<L> point = points<L>(lights, u);
    LightSample<L> s;
    s.target = point.p;
    s.radiance = point.emitted;
    const Vec3<L> d = s.target - from;
    const F squared = dot(d, d);
    s.direction = d * (F(1.0f) / sqrt(max(squared, F(1e-37f))));
    s.pdf_solid_angle = point.pdf_volume * squared;
    s.valid = s.pdf_solid_angle > F(0.0f);
    return s;
  }

  template <class L> static SHEAF_INLINE Uint<L> medium(const LightRecord<L>& light) {
    return light.template data<VolumeLightData>().medium;
  }

  static float pdf_volume(const SceneView& scene, std::uint32_t light, Vec3f p) {
    return volume_light_pdf(scene, light, p);
  }

  /// Isotropic directions.
  template <class L, ColorMode kMode>
  static SHEAF_INLINE PhotonEmission<L> emit(const LightQuery<L>& lights, const Random4<L>& a, const Random4<L>& b,
                                             TextureQuery<L>&) {
    using F = Float<L>;
    const VolumePoint<L> point = points<L>(lights, a);
    PhotonEmission<L> e;
    e.origin = point.p;
    e.direction = square_to_sphere<L>(b.x, b.y);
    e.pdf_position = point.pdf_volume;
    e.pdf_direction = F(kUniformSpherePdf);
    e.valid = point.pdf_volume > F(0.0f);
    e.flux = point.emitted * (F(4.0f * kPi) / select(e.valid, point.pdf_volume, F(1.0f)));
    return e;
  }

 private:
  /// Samples the active lanes one after the other; the others are 0.
  template <class L> static VolumePoint<L> points(const LightQuery<L>& lights, const Random4<L>& u) {
    constexpr int kWords = kLeafCount<VolumePoint>;
    alignas(kSimdAlignment) float number[3][L::width], wavelength[4][L::width], out[kWords][L::width] = {};
    alignas(kSimdAlignment) std::uint32_t media[L::width];
    store(media, lights.light.template data<VolumeLightData>().medium);
    store(number[0], u.y), store(number[1], u.z), store(number[2], u.w);
    store(wavelength[0], lights.lambda.c0), store(wavelength[1], lights.lambda.c1);
    store(wavelength[2], lights.lambda.c2), store(wavelength[3], lights.lambda.c3);
    for (std::uint32_t left = mask_bits(lights.active); left != 0; left &= left - 1) {
      const int i = std::countr_zero(left);
      VolumePoint<Scalar> found = sample_volume_light(
          lights.scene, lights.scene.media.rows[media[i]].light, {0.0f, number[0][i], number[1][i], number[2][i]},
          {wavelength[0][i], wavelength[1][i], wavelength[2][i], wavelength[3][i]});
      std::apply(
          [&](const auto&... leaf) {
            int k = 0;
            ((out[k++][i] = leaf), ...);
          },
          leaves(found));
    }
    VolumePoint<L> point;
    std::apply(
        [&](auto&... leaf) {
          int k = 0;
          (load(out[k++], leaf), ...);
        },
        leaves(point));
    return point;
  }
};

template <> struct LightOf<VolumeLightKind> { using Type = VolumeLight; };

}  // namespace sheaf

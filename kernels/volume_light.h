// Media as lights: points inside of them, chosen by what is emitted there.
//
// A volume light is a box with the sides of the world's axes, cut into cells; a cell is chosen by its share of the
// emission, a point in it uniformly. Points that lie in the box but not in the medium bring nothing: the shadow ray
// finds out (kernels/transmittance.cpp).
#pragma once

#include "core/rng.h"
#include "scene/medium_lookup.h"

namespace sheaf {

/// How LightRow::detail holds the number of cells along each axis.
struct VolumeCells {
  std::uint32_t x, y, z;
  explicit VolumeCells(std::uint32_t detail) : x(detail & 0x3ffu), y(detail >> 10 & 0x3ffu), z(detail >> 20) {}
};

/// The size of a volume light's box, metres.
inline Vec3f volume_light_size(const LightRow& light) { return {light.area, light.radius, light.depth}; }

/// The density, per cubic metre, of the point `p` of a volume light.
inline float volume_light_pdf(const SceneView& scene, std::uint32_t index, Vec3f p) {
  const LightRow& light = scene.lights[index];
  const VolumeCells cells(light.detail);
  const Vec3f size = volume_light_size(light);
  const auto place = [](float x, float lower, float extent, std::uint32_t count) {
    const float at = (x - lower) / extent * static_cast<float>(count);
    return at >= 0.0f && at <= static_cast<float>(count) ? std::min(to_uint(at), count - 1u) : kNone;
  };
  const std::uint32_t x = place(p.x, light.position[0], size.x, cells.x);
  const std::uint32_t y = place(p.y, light.position[1], size.y, cells.y);
  const std::uint32_t z = place(p.z, light.position[2], size.z, cells.z);
  if (x == kNone || y == kNone || z == kNone) return 0.0f;
  const AliasEntry& cell = scene.triangle_alias[light.first_triangle + (z * cells.y + y) * cells.x + x];
  return cell.pdf * static_cast<float>(light.triangle_count) / (size.x * size.y * size.z);
}

/// A point of a volume light.
struct VolumePoint {
  Vec3f p;
  float pdf_volume;   ///< per cubic metre
  Spectrum4 emitted;  ///< sigma_a times the radiance that the medium tends to, W / (m^3 sr)
};

/// By u.y, u.z and u.w. `lambda`: the path's wavelengths; not used in RGB mode.
inline VolumePoint sample_volume_light(const SceneView& scene, std::uint32_t index, const Random4<Scalar>& u,
                                       const Spectrum4& lambda) {
  const LightRow& light = scene.lights[index];
  const VolumeCells cells(light.detail);
  const Vec3f size = volume_light_size(light);
  const auto cell = sample_alias<Scalar>(scene.triangle_alias, light.first_triangle, light.triangle_count, u.w);
  // What is left of u.w depends on the cell; for the third coordinate its bits are scrambled instead.
  std::uint32_t a = float_bits(u.w), b = float_bits(u.y), c = float_bits(u.z), d = index;
  hash4(a, b, c, d);
  const float depth = light.triangle_count == 1 ? u.w : unit_float(a ^ b);
  const std::uint32_t x = cell.index % cells.x, y = cell.index / cells.x % cells.y, z = cell.index / cells.x / cells.y;
  VolumePoint out;
  out.p = {light.position[0] + size.x * ((static_cast<float>(x) + u.y) / static_cast<float>(cells.x)),
           light.position[1] + size.y * ((static_cast<float>(y) + u.z) / static_cast<float>(cells.y)),
           light.position[2] + size.z * ((static_cast<float>(z) + depth) / static_cast<float>(cells.z))};
  out.pdf_volume = cell.pdf * static_cast<float>(light.triangle_count) / (size.x * size.y * size.z);
  const MediumRow& medium = scene.media[light.shape];
  const MediumSpectra spectra = medium_spectra(scene, medium, lambda);
  out.emitted = to_spectrum(medium_coefficients(scene, medium, spectra, out.p, lambda).sigma_a *
                            medium_emission(scene, medium, spectra, out.p, lambda));
  return out;
}

}  // namespace sheaf

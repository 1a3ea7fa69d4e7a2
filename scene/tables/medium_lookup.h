// Coefficients and emission of media at a point, at a path's wavelengths.
#pragma once

#include "core/color/float4.h"
#include "scene/tables/scene_view.h"
#include "scene/tables/spectral_grid.h"

#include <cmath>
#include <iterator>

namespace sheaf {

/// The spectra of a medium's row at a path's wavelengths, without grids.
struct MediumSpectra {
  Float4 first, second, emission;  ///< see MediumRow
};

/// `lambda`: the path's wavelengths, nm; ignored in RGB mode.
inline MediumSpectra medium_spectra(const SceneView& scene, const MediumRow& medium, const Spectrum4& lambda) {
  if (scene.color == ColorMode::kRgb)
    return {Float4::load(medium.first), Float4::load(medium.second), Float4::load(medium.emission)};
  const auto row = static_cast<std::uint32_t>(&medium - scene.media.rows) * std::uint32_t{kMediumSpectra};
  const auto at = [&](std::uint32_t k) {
    return Float4(evaluate<Scalar>(scene.spectral.media, row + k, scene.spectral.tables, lambda));
  };
  return {at(0), at(1), (medium.flags & kMediumEmits) != 0 ? at(2) : Float4()};
}

/// Absorption, scattering and extinction coefficients, 1/m.
struct MediumCoefficients {
  Float4 sigma_a, sigma_s, sigma_t;
};

SHEAF_INLINE MediumCoefficients medium_coefficients(const MediumRow& medium, Float4 first, Float4 second) {
  if ((medium.flags & kMediumAbsorptionScattering) != 0) return {first, second, first + second};
  return {max(first - first * second, Float4()), first * second, first};
}

/// Coefficients of a homogeneous medium.
SHEAF_INLINE MediumCoefficients medium_coefficients(const MediumRow& medium, const MediumSpectra& spectra) {
  return medium_coefficients(medium, spectra.first, spectra.second);
}

/// Value of a grid at a point, as a factor for each lane.
inline Float4 grid_factor(const SceneView& scene, std::uint32_t grid, Vec3f p, const Spectrum4& lambda) {
  if (scene.media.grids.rows[grid].channels == 1) return Float4(max(lookup_grid(scene.media.grids, grid, p), 0.0f));
  if (scene.color == ColorMode::kSpectral) return lookup_grid_spectrum(scene.media.grids.rows[grid], p, lambda);
  const Vec3f rgb = lookup_grid_color(scene.media.grids, grid, p);
  return Float4(Spectrum4{max(rgb.x, 0.0f), max(rgb.y, 0.0f), max(rgb.z, 0.0f), 0.0f});
}

/// Whether `p` lies in the box of the medium's extinction grid.
inline bool is_in_box(const MajorantGridRow& row, Vec3f p) {
  for (int axis = 0; axis < 3; ++axis) {
    const float* m = row.world_to_grid + axis;
    const float at = m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12];
    if (!(at >= row.box_min[axis] && at <= row.box_max[axis])) return false;
  }
  return true;
}

/// Coefficients of any medium at world-space point `p`, without microflakes.
inline MediumCoefficients medium_coefficients(const SceneView& scene, const MediumRow& medium,
                                              const MediumSpectra& spectra, Vec3f p, const Spectrum4& lambda) {
  if ((medium.flags & kMediumBoxed) != 0 && !is_in_box(scene.media.majorants[medium.majorants], p)) return {};
  Float4 first = spectra.first, second = spectra.second;
  const bool by_albedo = (medium.flags & kMediumAbsorptionScattering) == 0;
  if (medium.first_grid != kNone) first = first * grid_factor(scene, medium.first_grid, p, lambda);
  if (medium.second_grid != kNone) second = second * grid_factor(scene, medium.second_grid, p, lambda);
  // In spectral mode, the spectrum of a saturated color may exceed 1 at some wavelengths, also as an albedo.
  if (by_albedo && scene.color == ColorMode::kRgb) second = min(second, Float4(1.0f));
  if (medium.density != kNone) {
    const float density = max(lookup_grid(scene.media.grids, medium.density, p), 0.0f);
    first = first * density;
    if (!by_albedo) second = second * density;
  }
  return medium_coefficients(medium, first, second);
}

/// Coefficients of a kMediumSingleGrid medium at point `p`, divided by the value of its grid there.
inline MediumCoefficients coefficients_per_density(const SceneView& scene, const MediumRow& medium,
                                                   const MediumSpectra& spectra, Vec3f p, const Spectrum4& lambda) {
  Float4 second = spectra.second;
  if (medium.second_grid != kNone) second = second * grid_factor(scene, medium.second_grid, p, lambda);
  const bool by_albedo = (medium.flags & kMediumAbsorptionScattering) == 0;
  if (by_albedo && scene.color == ColorMode::kRgb) second = min(second, Float4(1.0f));
  return medium_coefficients(medium, spectra.first, second);
}

/// The SGGX matrix of a medium at a point, as MediumRow::flakes.
struct FlakeMatrix {
  float entries[6];

  /// Projected area of the flakes in the direction `w`, relative to that of as many flakes that face it.
  float projected_area(Vec3f w) const {
    const auto& s = entries;
    const float diagonal = s[0] * w.x * w.x + s[1] * w.y * w.y + s[2] * w.z * w.z;
    return std::sqrt(max(diagonal + 2.0f * (s[3] * w.x * w.y + s[4] * w.x * w.z + s[5] * w.y * w.z), 0.0f));
  }
};

inline FlakeMatrix flake_matrix(const MediumRow& medium) {
  FlakeMatrix out;
  std::copy(std::begin(medium.flakes), std::end(medium.flakes), out.entries);
  return out;
}
inline FlakeMatrix flake_matrix(const SceneView& scene, const MediumRow& medium, Vec3f p) {
  if (medium.flake_grids == kNone) return flake_matrix(medium);
  const Vec3f a = lookup_grid_color(scene.media.grids, medium.flake_grids, p),
              b = lookup_grid_color(scene.media.grids, medium.flake_grids + 1, p);
  return {{a.x, a.y, a.z, b.x, b.y, b.z}};
}

/// Scales the spectra of a medium with microflakes to its extinction along `direction`, or to an upper bound if the
/// flakes vary in space.
inline void weigh_by_flakes(const MediumRow& medium, Vec3f direction, MediumSpectra& spectra) {
  const float area = medium.flake_grids == kNone ? flake_matrix(medium).projected_area(direction) : medium.max_flakes;
  spectra.first = spectra.first * area;
  if ((medium.flags & kMediumAbsorptionScattering) != 0) spectra.second = spectra.second * area;
}

/// Ratio of the extinction at point `p` to the bound of weigh_by_flakes(), in [0, 1].
inline float flake_projected_area(const SceneView& scene, const MediumRow& medium, Vec3f p, Vec3f direction) {
  if (medium.flake_grids == kNone) return 1.0f;
  const float area = flake_matrix(scene, medium, p).projected_area(direction);
  return area < medium.max_flakes ? area / medium.max_flakes : 1.0f;
}

/// Kelvin. Colder bodies do not emit visible light.
inline constexpr float kMinBlackbodyTemperature = 100;

/// Emission of a black body at a temperature in kelvin, for all lanes; see BlackbodyTable.
inline Float4 blackbody_emission(const SceneView& scene, float temperature, const Spectrum4& lambda) {
  if (!(temperature > 0.0f)) return Float4();
  if (scene.color == ColorMode::kRgb) {
    const Vec3f rgb = scene.media.blackbodies->at(temperature);
    return Float4(Spectrum4{rgb.x, rgb.y, rgb.z, 0.0f});
  }
  // Constants of Planck's law for W / (m^2 sr nm), nanometers and kelvin: 2 h c^2 and h c / k.
  constexpr float kFirst = 1.191042972e20f, kSecond = 1.438776877e7f;
  const Float4 l(lambda);
  const Float4 exponent = min(Float4(kSecond / temperature) / l, Float4(80.0f));
  const Float4 l2 = l * l;
  return Float4(kFirst) / (l2 * l2 * l) / (exp(exponent) - Float4(1.0f));
}

/// Reciprocal of the maximum of Planck's law over all wavelengths, by Wien's displacement law. The maximum grows with
/// the fifth power of the temperature.
inline float inverse_peak(float temperature) {
  constexpr float kRoot = 4.96511423f, kFirst = 1.191042972e20f, kSecond = 1.438776877e7f;  // x = 5 (1 - exp(-x))
  const float l = kSecond / (kRoot * temperature);
  return (std::exp(kRoot) - 1.0f) * (l * l / kFirst) * (l * l) * l;
}

/// Radiance of an optically thick volume of the medium at world-space point `p`.
inline Float4 medium_emission(const SceneView& scene, const MediumRow& medium, const MediumSpectra& spectra, Vec3f p,
                              const Spectrum4& lambda) {
  Float4 emission = spectra.emission;
  if (medium.emission_grid != kNone) emission = emission * grid_factor(scene, medium.emission_grid, p, lambda);
  if (medium.temperature != kNone) {
    const float found = lookup_grid(scene.media.grids, medium.temperature, p);
    const float kelvin = (found - medium.temperature_offset) * medium.temperature_scale;
    emission = emission * blackbody_emission(scene, kelvin, lambda);
    if ((medium.flags & kMediumUnitBlackbodies) != 0)
      emission = kelvin > kMinBlackbodyTemperature ? emission * inverse_peak(kelvin) : Float4();
  }
  if (medium.emission_factor != kNone)
    emission = emission * max(lookup_grid(scene.media.grids, medium.emission_factor, p), 0.0f);
  return emission;
}

}  // namespace sheaf

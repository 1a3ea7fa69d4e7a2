// Media and phase functions of a scene.
#pragma once

#include "core/io/error.h"
#include "scene/description/grid_volume.h"
#include "scene/description/inputs.h"

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sheaf {

/// A quantity of a medium: a constant or a grid.
using VolumeInput = std::variant<SpectrumDescription, GridVolumeDescription>;

/// Isotropic scattering.
struct IsotropicPhaseDescription {};
/// Henyey and Greenstein 1941. `g` is the mean cosine of the scattering angle, in (-1, 1); positive: forwards.
struct HenyeyGreensteinDescription {
  float g = 0.8f;
};
/// Rayleigh scattering, by particles much smaller than the wavelength.
struct RayleighDescription {};
/// A tabulated phase function, up to a factor. Values lie at cosines of the scattering angle from -1 to 1 in equal
/// steps, with linear interpolation. At least two values, not negative, not all zero.
struct TabulatedPhaseDescription {
  std::vector<float> values;
};
/// Specular microflakes, SGGX (Heitz et al. 2015). The matrix S in world space as xx, yy, zz, xy, xz, yz: a constant,
/// or a grid of six channels. The medium's extinction is multiplied by the projected area of the flakes.
struct SggxDescription {
  std::variant<std::array<float, 6>, GridVolumeDescription> matrix;
};
/// (1 - weight) nested[0] + weight nested[1].
struct BlendPhaseDescription {
  float weight = 0.5f;
  PhaseId nested[2]{};
};

struct PhaseDescription {
  std::variant<IsotropicPhaseDescription, HenyeyGreensteinDescription, RayleighDescription, TabulatedPhaseDescription,
               SggxDescription, BlendPhaseDescription>
      model;
  SourceLocation where;
};

/// A medium given by extinction and albedo.
struct ExtinctionAlbedoDescription {
  VolumeInput sigma_t = SpectrumDescription::constant(1);
  VolumeInput albedo = SpectrumDescription::constant(0.75f);
};
/// A medium given by absorption and scattering.
struct AbsorptionScatteringDescription {
  VolumeInput sigma_a, sigma_s;  ///< if one is a grid, both must be, with the same voxels
};

/// A medium inside or outside of shapes. Coefficients are in 1/m of world space. All grids of a medium move alike: from
/// their positions at the first key, by the same affine map.
struct MediumDescription {
  std::variant<ExtinctionAlbedoDescription, AbsorptionScatteringDescription> coefficients;
  std::optional<GridVolumeDescription> density;  ///< multiplies the coefficients; one channel
  float scale = 1;                               ///< multiplies the coefficients
  /// Radiance of an optically thick volume of the medium, W / (m^2 sr): the medium emits sigma_a times this per meter.
  std::optional<VolumeInput> emission;
  std::optional<GridVolumeDescription>
      emission_factor;  ///< multiplies the emission, also that of `temperature`; one channel
  /// Temperature grid, one channel. T = temperature_scale (value - temperature_offset) in kelvin. The medium emits as a
  /// black body of temperature T (Planck's law, W / (m^2 sr nm)). Replaces `emission`.
  std::optional<GridVolumeDescription> temperature;
  float temperature_scale = 1, temperature_offset = 0;
  bool unit_blackbodies = false;  ///< divide each black-body spectrum by its maximum over all wavelengths
  float emission_scale = 1;       ///< multiplies the emission
  std::optional<PhaseId> phase;   ///< default: isotropic
  std::string id;                 ///< name for messages; may be empty
  SourceLocation where;
};

}  // namespace sheaf

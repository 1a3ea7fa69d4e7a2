// Participating media as kernels see them.
#pragma once

#include "core/vec.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// Bits of MediumRow::flags.
enum MediumFlags : std::uint32_t {
  kMediumHomogeneous = 1,  ///< the same everywhere
  kMediumScatters = 2,     ///< not only absorbs
  kMediumEmits = 4,
  kMediumAbsorptionScattering = 8,  ///< its spectra are those two, else extinction and albedo
  kMediumGrey = 16,                 ///< extinction is the same in all lanes
  kMediumBoxed = 64,                ///< ends at the box of the grid of its extinction, whatever the grid has outside
  kMediumColored = 32,              ///< extinction has a grid of three channels
  kMediumFlakes = 128,              ///< extinction is multiplied by the projected area of microflakes
  kMediumUnitBlackbodies = 256,     ///< see MediumDescription::unit_blackbodies
  /// Extinction is that of the spectra times one grid of one channel, which ends with background or is clamped: many
  /// rays at a time are tracked through it, and unless it glows its majorants have minorants.
  kMediumSingleGrid = 512,
};

/// One medium. Coefficients are per metre of world space. In spectral mode the three spectra are those of
/// SpectralView::media instead, kMediumSpectra for each medium.
struct MediumRow {
  std::uint32_t flags = 0;                ///< MediumFlags
  std::uint32_t phase = 0;                ///< row of the material that is its phase function, maybe a composite one
  std::uint32_t light = 0xffffffffu;      ///< row of the light that it is; kNone: none
  std::uint32_t majorants = 0xffffffffu;  ///< into SceneView::majorant_grids; kNone: homogeneous
  float first[4] = {};                    ///< sigma_t, or sigma_a
  float second[4] = {};                   ///< albedo, or sigma_s
  float emission[4] = {};                 ///< radiance: per metre sigma_a times as much is emitted
  // What multiplies them: rows of SceneView::grids; kNone: nothing does.
  std::uint32_t density = 0xffffffffu;  ///< both coefficients; one channel
  std::uint32_t first_grid = 0xffffffffu;
  std::uint32_t second_grid = 0xffffffffu;
  std::uint32_t emission_grid = 0xffffffffu;
  std::uint32_t temperature = 0xffffffffu;  ///< Kelvin: the emission is a black body's; one channel
  float temperature_scale = 1;              ///< on that grid, less temperature_offset
  float temperature_offset = 0;
  std::uint32_t emission_factor = 0xffffffffu;  ///< the emission; one channel
  float step_size = 0;                          ///< MediumEstimator::kMarching: metres
  // kMediumFlakes: the matrix of SggxDescription.
  float flakes[6] = {};                     ///< xx, yy, zz, xy, xz, yz, where it is the same everywhere
  std::uint32_t flake_grids = 0xffffffffu;  ///< else grids of xx, yy, zz and, the next row, of xy, xz, yz
  float most_flakes = 0;                    ///< of that grid: bounds the projected area
};
inline constexpr int kMediumSpectra = 3;
/// Most media in a scene: as many as kernels/wave/path_state.h has bits for.
inline constexpr std::uint32_t kMaxMedia = 0xfffffeu;

/// Linear Rec.709 of black bodies by temperature, for RGB mode.
struct BlackbodyTable {
  static constexpr float kStep = 10;  ///< kelvin between entries
  static constexpr int kEntries = 2001;
  /// Planck's law, W / (m^2 sr nm), at 0, kStep, 2 kStep, ... kelvin; hotter ones are as the last.
  std::vector<Vec3f> rgb;

  BlackbodyTable();
  Vec3f at(float temperature) const {
    const float place = std::min(temperature / kStep, static_cast<float>(kEntries - 1));
    const int i = std::min(static_cast<int>(place), kEntries - 2);
    const float t = place - static_cast<float>(i);
    return rgb[static_cast<std::size_t>(i)] * (1.0f - t) + rgb[static_cast<std::size_t>(i) + 1] * t;
  }
};

/// The media on both sides of a surface: 0 for vacuum, else 1 + the row.
struct BoundaryRow {
  std::uint32_t interior = 0;  ///< behind the geometric normal
  std::uint32_t exterior = 0;
};

}  // namespace sheaf

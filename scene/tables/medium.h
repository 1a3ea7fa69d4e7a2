// Participating media for kernels.
#pragma once

#include "core/math/vec.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// Bits of MediumRow::flags.
enum MediumFlags : std::uint32_t {
  kMediumHomogeneous = 1,  ///< constant coefficients
  kMediumScatters = 2,     ///< has scattering, not only absorption
  kMediumEmits = 4,
  kMediumAbsorptionScattering = 8,  ///< spectra are absorption and scattering; otherwise extinction and albedo
  kMediumGray = 16,                 ///< extinction is equal in all lanes
  kMediumBoxed = 64,                ///< ends at the box of its extinction grid, regardless of the grid's border
  kMediumColored = 32,              ///< extinction has a three-channel grid
  kMediumFlakes = 128,              ///< extinction is multiplied by the projected area of microflakes
  kMediumUnitBlackbodies = 256,     ///< see MediumDescription::unit_blackbodies
  /// Extinction is a spectrum times one single-channel grid, which is clamped or has a background. Such media are
  /// tracked for many rays at a time. Their majorant grids include minorants unless they emit.
  kMediumSingleGrid = 512,
  kMediumConnects = 1024,  ///< rays are connected to lights; see scene/compile/media/connect_media.cpp
};

/// One medium. Coefficients are in 1/m of world space. In spectral mode, the three spectra are taken from
/// SpectralView::media instead, kMediumSpectra for each medium.
struct MediumRow {
  std::uint32_t flags = 0;                ///< MediumFlags
  std::uint32_t phase = 0;                ///< row of the phase function's material, possibly a composite
  std::uint32_t light = 0xffffffffu;      ///< row of its volume light; kNone: none
  std::uint32_t majorants = 0xffffffffu;  ///< into MediumView::majorants; kNone: homogeneous
  float first[4] = {};                    ///< sigma_t, or sigma_a
  float second[4] = {};                   ///< albedo, or sigma_s
  float mean_extinction = 0;              ///< over colors and, weighted by the density, the volume; 1/m
  float emission[4] = {};                 ///< radiance; emission per meter is sigma_a times this
  // Grids that multiply the above: rows of MediumView::grids; kNone: no grid.
  std::uint32_t density = 0xffffffffu;  ///< multiplies both coefficients; one channel
  std::uint32_t first_grid = 0xffffffffu;
  std::uint32_t second_grid = 0xffffffffu;
  std::uint32_t emission_grid = 0xffffffffu;
  std::uint32_t temperature = 0xffffffffu;  ///< kelvin: the emission is that of a black body; one channel
  float temperature_scale = 1;              ///< multiplies the grid's value minus temperature_offset
  float temperature_offset = 0;
  std::uint32_t emission_factor = 0xffffffffu;  ///< multiplies the emission; one channel
  float step_size = 0;                          ///< MediumEstimator::kMarching: step in meters
  // kMediumFlakes: the matrix of SggxDescription.
  float flakes[6] = {};                     ///< xx, yy, zz, xy, xz, yz if constant
  std::uint32_t flake_grids = 0xffffffffu;  ///< otherwise grids of xx, yy, zz and, in the next row, of xy, xz, yz
  float max_flakes = 0;                     ///< upper bound on the projected area over that grid
};
/// kMediumConnects: mean optical thickness up to which rays are connected to lights. The rest contributes little.
inline constexpr float kSegmentDepth = 6;
inline constexpr int kMediumSpectra = 3;
/// Maximum number of media in a scene, limited by the bits in kernels/wave/path_state.h.
inline constexpr std::uint32_t kMaxMedia = 0xfffffeu;

/// Linear Rec.709 of black bodies by temperature, for RGB mode.
struct BlackbodyTable {
  static constexpr float kStep = 10;  ///< kelvin between entries
  static constexpr int kEntries = 2001;
  /// Planck's law, W / (m^2 sr nm), at 0, kStep, 2 kStep, ... kelvin. Higher temperatures use the last entry.
  std::vector<Vec3f> rgb;

  BlackbodyTable();
  Vec3f at(float temperature) const {
    const float position = std::min(temperature / kStep, static_cast<float>(kEntries - 1));
    const int i = std::min(static_cast<int>(position), kEntries - 2);
    const float t = position - static_cast<float>(i);
    return rgb[static_cast<std::size_t>(i)] * (1.0f - t) + rgb[static_cast<std::size_t>(i) + 1] * t;
  }
};

/// The media on both sides of a surface: 0 for vacuum, else 1 + the row.
struct BoundaryRow {
  std::uint32_t interior = 0;  ///< behind the geometric normal
  std::uint32_t exterior = 0;  ///< unless MediumView::surroundings has rows for the instance; see exterior_medium()
  std::uint32_t first_surrounding = 0, surrounding_count = 0;  ///< into MediumView::surroundings
};

/// The medium outside of a boundary from a time on. Rows of a boundary are in the order of instance and time. The first
/// one of each instance has time 0.
struct SurroundingRow {
  std::uint32_t instance;  ///< kNone: a shape outside of groups
  float time;              ///< in [0, 1] over the shutter
  std::uint32_t medium;    ///< 0 for vacuum, else 1 + the row
};

/// A medium in which the rays of a camera start, from a time on.
struct CameraMediumRow {
  std::uint32_t camera;  ///< in the order of the film's columns
  float time;            ///< in [0, 1] over the shutter
  std::uint32_t medium;  ///< 0 for vacuum, else 1 + the row
};

}  // namespace sheaf

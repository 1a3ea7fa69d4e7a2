// Checks that the coefficients and emission of media are finite: the product of finite factors may overflow.
#include "core/color/color.h"
#include "scene/compile/media/compile_media.h"
#include "scene/tables/medium_lookup.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

bool is_finite(Float4 v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]) && std::isfinite(v[3]);
}

/// Maximum factor of a grid. A spectrum may exceed the color that it represents.
float largest_factor(std::span<const BrickGrid> grids, std::uint32_t grid) {
  if (grid == kNone) return 1.0f;
  return std::max(grids[grid].max_value(), 0.0f) * (grids[grid].channels > 1 ? 2.0f : 1.0f);
}

/// Throws SceneError unless all products are finite at four wavelengths.
void check_at(const SceneView& scene, std::uint32_t index, const Spectrum4& lambda, std::span<const BrickGrid> grids,
              float bound, const SourceLocation& where) {
  const MediumRow& medium = scene.media.rows[index];
  const MediumSpectra spectra = medium_spectra(scene, medium, lambda);
  const bool by_albedo = (medium.flags & kMediumAbsorptionScattering) == 0;
  const Float4 sigma_t = (by_albedo ? spectra.first : spectra.first + spectra.second) * bound;
  Float4 albedo = spectra.second * largest_factor(grids, medium.second_grid);
  if (scene.color == ColorMode::kRgb) albedo = min(albedo, Float4(1.0f));
  if (!is_finite(sigma_t) || !is_finite(spectra.second) || (by_albedo && !is_finite(sigma_t * albedo)))
    throw SceneError(
        where,
        "the medium's extinction exceeds 32-bit floats somewhere (expected values whose product with 'scale' "
        "and the grids' voxels is finite)");
  if ((medium.flags & kMediumEmits) == 0) return;
  Float4 emission = spectra.emission * largest_factor(grids, medium.emission_grid);
  if (medium.temperature != kNone) {
    const float largest = largest_factor(grids, medium.temperature) - medium.temperature_offset;
    const float kelvin = largest * medium.temperature_scale;
    const bool of_one = (medium.flags & kMediumUnitBlackbodies) != 0;
    if (!std::isfinite(kelvin))
      emission = Float4(kInfinity);
    else if (!of_one)
      emission = emission * blackbody_emission(scene, kelvin, lambda);
  }
  emission = emission * largest_factor(grids, medium.emission_factor);
  if (!is_finite(emission))
    throw SceneError(
        where,
        "the medium's emission exceeds 32-bit floats somewhere (expected values whose product with the scale "
        "and the grids' voxels is finite)");
}

/// Throws SceneError unless the coefficients and the emission are finite everywhere.
void check_medium(const SceneView& scene, std::uint32_t index, const MediumTables& tables,
                  const SourceLocation& where) {
  const MediumRow& medium = scene.media.rows[index];
  const std::vector<MajorantGrid>& majorants = tables.majorants;
  const bool varies = medium.majorants != kNone && !majorants[medium.majorants].bounds.empty();
  float bound = varies ? majorants[medium.majorants].max_value() : 1.0f;
  if ((medium.flags & kMediumFlakes) != 0) bound *= std::max(medium.max_flakes, 1.0f);
  if (scene.color == ColorMode::kRgb) return check_at(scene, index, {}, tables.grids, bound, where);
  for (float nm = kWavelengthMin; nm < kWavelengthMax; nm += 4.0f)
    check_at(scene, index, {nm, nm + 1, nm + 2, nm + 3}, tables.grids, bound, where);
}

/// Removes extinction and emission from a medium.
void make_empty(std::uint32_t index, SceneTables& scene) {
  MediumRow& medium = scene.media.rows[index];
  for (float* const words : {medium.first, medium.second, medium.emission}) std::fill_n(words, 4, 0.0f);
  medium.flags &= ~(kMediumEmits | kMediumScatters);
  if (scene.spectra.media.empty()) return;
  for (std::size_t i = 0; i < kMediumSpectra; ++i) scene.spectra.media[kMediumSpectra * index + i].scale = 0;
}

}  // namespace

void check_media(std::span<const MediumDescription> media, ErrorSink& errors, SceneTables& scene) {
  for (std::uint32_t i = 0; i < media.size(); ++i) {
    try {
      check_medium(scene.view(), i, scene.media, media[i].where);
    } catch (const SceneError& error) {
      errors.report(error, kEmptySubstitute);
      make_empty(i, scene);
    }
  }
}

}  // namespace sheaf

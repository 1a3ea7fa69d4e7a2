// Builds the closure tables of a scene.
#pragma once

#include "scene/formats/measured_file.h"
#include "scene/formats/polarized_brdf.h"
#include "scene/tables/closure_tables.h"

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sheaf {

/// Appends tables to the future MaterialView::closure_tables. Each function returns the word by which closures refer to
/// the table. It throws SceneError if all tables together are too large.
class ClosureTables {
 public:
  /// Properties of a measured BRDF's table that its material needs.
  struct Measured {
    float table = 0;
    bool isotropic = true;
    std::vector<float> wavelengths;  ///< wavelengths of its channels; empty: red, green, blue
  };

  /// Table of a file, which is read once. In RGB mode spectra are converted to colors under D65. Throws SceneError.
  const Measured& measured(const std::filesystem::path& file, bool spectral);

  /// Table of a BRDF that is already in memory.
  float measured(const MeasuredBrdf& brdf);

  /// Table of a file with a polarimetric BRDF, which is read once per set of arguments; see MeasuredDescription. In RGB
  /// mode spectra are converted to colors under D65. Throws SceneError.
  const Measured& polarized(const std::filesystem::path& file, float alpha_sample, float wavelength, bool spectral);

  /// Table of a polarimetric BRDF that is already in memory, in [kMinAlpha, kMaxAlpha]: `alpha_sample`.
  float polarized(const PolarizedBrdf& brdf, float alpha_sample);

  /// Table of a phase function from the values of TabulatedPhaseDescription.
  float phase(std::span<const float> values);

  /// Returns all tables and clears this object.
  std::vector<float> take() { return std::exchange(floats_, {}); }

 private:
  float add(const std::vector<float>& table);

  std::vector<float> floats_;
  std::map<std::string, Measured> known_;
};

/// Converts values at many wavelengths to linear Rec.709, clamped to 0. A reflectance of 1 at all wavelengths under D65
/// becomes (1, 1, 1). Beyond the file's range, its first and last values are used.
void make_rgb(MeasuredBrdf& brdf);
void make_rgb(PolarizedBrdf& brdf);

/// Reduces the values to those at one wavelength, in nm. Beyond the file's range, its first or last values are used.
void select_wavelength(PolarizedBrdf& brdf, float wavelength);

/// Fractional indices of the wavelengths 360, 361, ... 830 nm in a list of wavelengths.
std::vector<float> wavelength_positions(const std::vector<float>& wavelengths);

}  // namespace sheaf

// Builds the closure tables of a scene.
#pragma once

#include "scene/formats/measured_file.h"
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

/// Fractional indices of the wavelengths 360, 361, ... 830 nm in a list of wavelengths.
std::vector<float> wavelength_positions(const std::vector<float>& wavelengths);

}  // namespace sheaf

// Tables of closures on their way into the scene.
#pragma once

#include "scene/formats/measured_file.h"
#include "scene/tables/closure_tables.h"

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace sheaf {

/// Appends tables to what becomes SceneView::closure_tables. Each returns the word by which closures refer to it, and
/// throws SceneError once all tables together are too large.
class ClosureTables {
 public:
  /// What a material needs to know about a measured BRDF's table.
  struct Measured {
    float table = 0;
    bool isotropic = true;
    std::vector<float> wavelengths;  ///< of its channels; empty: red, green, blue
  };

  /// The tables of a file, which is read once. In RGB mode spectra become colours under D65. Throws SceneError.
  const Measured& measured(const std::filesystem::path& file, bool spectral);

  /// Tables that are there already.
  float measured(const MeasuredBrdf& brdf);

  /// Values of a phase function as TabulatedPhaseDescription has them.
  float phase(std::span<const float> values);

  /// Leaves none behind.
  std::vector<float> take() { return std::exchange(floats_, {}); }

 private:
  float add(const std::vector<float>& table);

  std::vector<float> floats_;
  std::map<std::string, Measured> known_;
};

/// Its values for many wavelengths as values for red, green and blue, none negative: linear Rec.709, a reflectance of 1
/// at all wavelengths under D65 being (1, 1, 1). Beyond the wavelengths of the file its ends go on.
void make_rgb(MeasuredBrdf& brdf);

/// Where the wavelengths 360, 361, ... 830 nm lie among a table's: their index, with a fraction in between.
std::vector<float> places_of_wavelengths(const std::vector<float>& wavelengths);

}  // namespace sheaf

// Compiles spectra of scene files into the rows and tables of spectral mode.
#pragma once

#include "core/color/spectrum_row.h"
#include "scene/description/dispersion.h"
#include "scene/description/inputs.h"

#include <map>
#include <vector>

namespace sheaf {

/// Use of a spectrum; determines the conversion of colors and constants.
enum class SpectrumUse {
  kReflectance,  ///< reflectance, transmittance, albedo: in [0, 1]; colors are defined under D65
  kIlluminant,   ///< emission: colors and constants are relative to D65, tables and black bodies absolute
  kUnbounded,    ///< indices of refraction, coefficients of media, scales: colors are defined under D65
  kRaw,          ///< a scalar: the same at all wavelengths; the luminance of a color
};

/// Rows and tables of one scene, in the units of RGB mode. An emitter of value 1 at all wavelengths has Y = 1. So has
/// an emitter of constant 1, which has the spectrum of D65.
class SpectrumSet {
 public:
  /// Starts with table 1, D65 with Y = 1.
  SpectrumSet();

  /// The row of a description. Throws SceneError for tables rejected by check_table() and for numbers that are not
  /// finite. Negative numbers are clamped to 0, reflectances to [0, 1].
  SpectrumRow row(const SpectrumDescription& spectrum, SpectrumUse use);

  /// A row from samples at 360, 361, ... 830 nm; equal tables are stored once.
  SpectrumRow tabulate(std::vector<float> samples);

  /// Valid until the next call of row() or tabulate().
  SpectrumTableView view() const { return {samples_.data()}; }
  const std::vector<float>& samples() const { return samples_; }

 private:
  std::vector<float> samples_;                         ///< SpectrumTableView::kStride per table
  std::map<std::vector<float>, std::uint32_t> known_;  ///< table of each list of samples
};

/// Resamples a table at 360, 361, ... 830 nm with a hat function of radius 1 nm. Lines narrower than the steps keep
/// their power, and linear tables are preserved.
std::vector<float> resample(const SpectrumDescription::Table& table);

/// Tabulates a dispersion formula; within 1e-6 of ior().
SpectrumRow dispersion_row(SpectrumSet& set, const Dispersion& dispersion);

}  // namespace sheaf

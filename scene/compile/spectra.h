// What scene files say about spectra, as the rows and tables that kernels read in spectral mode.
#pragma once

#include "core/spectrum_row.h"
#include "scene/description/description.h"

#include <map>
#include <vector>

namespace sheaf {

/// What a spectrum stands for; decides what colours and constants become.
enum class SpectrumUse {
  kReflectance,  ///< reflectance, transmittance, albedo: within [0, 1]; colours are seen under D65
  kIlluminant,   ///< emission: colours and constants are relative to D65, tables and black bodies absolute
  kUnbounded,    ///< indices of refraction, coefficients of media, scales: colours are seen under D65
  kRaw,          ///< a number: the same at every wavelength; of a colour its luminance
};

/// Rows and tables of one scene. The units are those of RGB mode: an emitter of 1 at every wavelength has Y = 1, and so
/// has one of the constant 1, which has the spectrum of D65.
class SpectrumSet {
 public:
  /// With table 1, D65 of Y = 1.
  SpectrumSet();

  /// The row that stands for a description. Throws SceneError for tables that check_table() refuses and numbers that
  /// are not finite. Negative numbers become 0; reflectances are cut off at 1.
  SpectrumRow row(const SpectrumDescription& spectrum, SpectrumUse use);

  /// A row of samples at 360, 361, ... 830 nm, for spectra given by formulas; equal ones are stored once.
  SpectrumRow tabulate(std::vector<float> samples);

  /// Valid until the next row or tabulate.
  SpectrumTableView view() const { return {samples_.data()}; }
  const std::vector<float>& samples() const { return samples_; }

 private:
  std::vector<float> samples_;                         ///< SpectrumTableView::kStride for each table
  std::map<std::vector<float>, std::uint32_t> known_;  ///< table of each list of samples
};

/// The table at 360, 361, ... 830 nm: each value is the mean over 1 nm to both sides, weighted linearly down to nothing
/// there. So a line narrower than the steps keeps its power, and what is linear stays as it is.
std::vector<float> resample(const SpectrumDescription::Table& table);

/// The formula as a row for kernels: within 1e-6 of ior().
SpectrumRow dispersion_row(SpectrumSet& set, const Dispersion& dispersion);

}  // namespace sheaf

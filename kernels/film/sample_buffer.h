// Buffer of finished camera samples, from which they are added to the film.
#pragma once

#include "kernels/film/id_coverage.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace sheaf {

/// Contributions of the wavelengths of a camera sample to a film with spectral bins.
struct SpectralSample {
  std::uint16_t bin[4] = {};
  float value[4] = {};  ///< spectral radiance over the pdf of the wavelength, times the filter's weight
};

/// Position of a sample relative to the center of its pixel, pixels.
struct SampleOffset {
  float x = 0, y = 0;
};

/// First surface of a camera sample.
struct SurfaceSample {
  std::uint32_t shape = IdCoverage::kNothing;  ///< row of GeometryView::shapes
  float weight = 1;                            ///< the filter's weight
};

/// The samples of a task. The channels of a sample are contiguous and follow the film's layout. If samples contribute
/// only to their own pixel, the values include the filter's weight.
class SampleBuffer {
 public:
  /// Makes room for `samples` samples of `channels` channels (at least one). `spectral`: adds SpectralSamples.
  /// `surfaces`: adds SurfaceSamples, initialized to no surface.
  void resize(int samples, int channels, bool spectral, bool surfaces = false) {
    channels_ = channels;
    values_.resize(static_cast<std::size_t>(samples) * static_cast<std::size_t>(channels));
    offsets_.resize(static_cast<std::size_t>(samples));
    spectra_.resize(spectral ? static_cast<std::size_t>(samples) : 0);
    surfaces_.assign(surfaces ? static_cast<std::size_t>(samples) : 0, {});
  }

  /// Sets all channels of all samples to zero.
  void clear() { std::fill(values_.begin(), values_.end(), 0.0f); }

  int channels() const { return channels_; }
  /// The channels of a sample.
  float* operator[](std::size_t sample) { return values_.data() + sample * static_cast<std::size_t>(channels_); }
  const float* operator[](std::size_t sample) const {
    return values_.data() + sample * static_cast<std::size_t>(channels_);
  }
  SampleOffset& offset(std::size_t sample) { return offsets_[sample]; }
  const SampleOffset& offset(std::size_t sample) const { return offsets_[sample]; }
  bool has_spectra() const { return !spectra_.empty(); }
  SpectralSample& spectrum(std::size_t sample) { return spectra_[sample]; }
  const SpectralSample& spectrum(std::size_t sample) const { return spectra_[sample]; }
  bool has_surfaces() const { return !surfaces_.empty(); }
  SurfaceSample& surface(std::size_t sample) { return surfaces_[sample]; }
  const SurfaceSample& surface(std::size_t sample) const { return surfaces_[sample]; }

  /// Marks a sample that must not reach the film.
  void drop(std::size_t sample) { (*this)[sample][0] = std::numeric_limits<float>::quiet_NaN(); }
  bool is_dropped(std::size_t sample) const { return std::isnan((*this)[sample][0]); }

 private:
  int channels_ = 0;
  std::vector<float> values_;
  std::vector<SampleOffset> offsets_;
  std::vector<SpectralSample> spectra_;
  std::vector<SurfaceSample> surfaces_;
};

}  // namespace sheaf

// The film: sums of samples per pixel, from which the picture and its variance are made.
#pragma once

#include "core/image.h"
#include "scene/description.h"

#include <array>

namespace sheaf {

/// A finished camera sample: radiance (linear Rec.709) and coverage, premultiplied.
struct FilmSample {
  float r = 0, g = 0, b = 0, alpha = 0;
};

/// What the wavelengths of a finished camera sample add to a film with spectral bins.
struct SpectralSample {
  std::uint16_t bin[4] = {};
  float value[4] = {};  ///< spectral radiance over the density of the wavelength, the filter's weight included
};

/// Most bins: one for every nm from 360 to 830.
inline constexpr int kMaxSpectralBins = 471;

/// Pixel sums in double precision. Samples of one pixel must be added in the order of their sample index; different
/// pixels may be added to by different threads at once.
class Film {
 public:
  Film() = default;
  /// `crop` must lie inside the frame. `spectral_bins`: of equal width from 360 to 830 nm, at most kMaxSpectralBins.
  Film(int frame_width, int frame_height, PixelRect crop, int spectral_bins = 0);

  int width() const { return frame_width_; }
  int height() const { return frame_height_; }
  const PixelRect& crop() const { return crop_; }
  int spectral_bins() const { return spectral_bins_; }

  /// Adds a sample to the pixel (x, y) of the frame, which must lie inside the crop.
  void add(int x, int y, const FilmSample& sample) {
    Pixel& p = pixels_[index(x, y)];
    const double v[3] = {sample.r, sample.g, sample.b};
    for (int c = 0; c < 3; ++c) {
      p.sum[c] += v[c];
      p.sum_of_squares[c] += v[c] * v[c];
    }
    p.alpha += sample.alpha;
    ++p.count;
  }

  /// Adds the wavelengths of a sample that add() was called with, to a film that has bins.
  void add_spectrum(int x, int y, const SpectralSample& sample) {
    double* bins = spectra_.data() + index(x, y) * static_cast<std::size_t>(spectral_bins_);
    for (int k = 0; k < 4; ++k) bins[sample.bin[k]] += static_cast<double>(sample.value[k]);
  }

  /// The picture: R, G, B, A (means), variance.R/G/B (of the mean, as if samples
  /// were independent; zero below two samples) and sampleCount, over the
  /// crop. Pixels without samples are zero. A film with bins has the mean spectral radiance over each of them besides,
  /// in channels as of Fichet, Pacanowski and Wilkie, "An OpenEXR Layout for Spectral Images" (2021): the name of the
  /// bin around 550 nm is "S0.550,000000nm".
  Image to_image() const;

 private:
  struct Pixel {
    std::array<double, 3> sum{}, sum_of_squares{};
    double alpha = 0;
    std::uint64_t count = 0;
  };

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - crop_.y0) * static_cast<std::size_t>(crop_.width()) +
           static_cast<std::size_t>(x - crop_.x0);
  }

  int frame_width_ = 0, frame_height_ = 0;
  PixelRect crop_;
  std::vector<Pixel> pixels_;
  int spectral_bins_ = 0;
  std::vector<double> spectra_;  ///< sums, all bins of a pixel together
};

}  // namespace sheaf

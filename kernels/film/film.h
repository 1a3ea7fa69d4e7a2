// The film: sums of samples per pixel, from which the picture and its variance are made.
#pragma once

#include "core/image.h"
#include "core/pixel_rect.h"
#include "kernels/film/film_layout.h"
#include "kernels/film/sample_buffer.h"

namespace sheaf {

/// Most bins: one for every nm from 360 to 830.
inline constexpr int kMaxSpectralBins = 471;

/// Pixel sums in double precision. Samples of one pixel must be added in the order of their sample index; different
/// pixels may be added to by different threads at once.
class Film {
 public:
  Film() = default;
  /// `crop` must lie inside the frame. `spectral_bins`: of equal width from 360 to 830 nm, at most kMaxSpectralBins.
  Film(int frame_width, int frame_height, PixelRect crop, FilmLayout layout = FilmLayout::beauty(),
       int spectral_bins = 0);

  int width() const { return frame_width_; }
  int height() const { return frame_height_; }
  const PixelRect& crop() const { return crop_; }
  const FilmLayout& layout() const { return layout_; }
  int spectral_bins() const { return spectral_bins_; }

  /// Adds the sample `index` of a buffer with the film's layout to the pixel (x, y) of the frame, which must lie inside
  /// the crop; nothing if the sample was dropped.
  void add(int x, int y, const SampleBuffer& samples, std::size_t index) {
    if (samples.is_dropped(index)) return;
    const std::size_t pixel = pixel_index(x, y), channels = has_variance_.size();
    const float* sample = samples[index];
    double* sum = sums_.data() + pixel * channels;
    double* square = squares_.data() + pixel * variances_;
    for (std::size_t c = 0; c < channels; ++c) {
      const double value = sample[c];
      sum[c] += value;
      if (has_variance_[c]) *square++ += value * value;
    }
    ++counts_[pixel];
    if (spectral_bins_ > 0) add_spectrum(pixel, samples.spectrum(index));
  }

  /// How many samples the pixel (x, y) of the frame, inside the crop, has received.
  std::uint64_t count(int x, int y) const { return counts_[pixel_index(x, y)]; }

  /// The picture over the crop: the mean of each channel, the variances (of the mean, as if samples were independent;
  /// zero below two samples) and sampleCount. Pixels without samples are zero. A film with bins has the mean spectral
  /// radiance over each of them besides, in channels as of Fichet, Pacanowski and Wilkie, "An OpenEXR Layout for
  /// Spectral Images" (2021): the name of the bin around 550 nm is "S0.550,000000nm".
  Image to_image() const;

 private:
  friend void write_film(const std::filesystem::path& file, const Film& film);
  friend Film read_film(const std::filesystem::path& file);

  std::size_t pixel_index(int x, int y) const {
    return static_cast<std::size_t>(y - crop_.y0) * static_cast<std::size_t>(crop_.width()) +
           static_cast<std::size_t>(x - crop_.x0);
  }
  void add_spectrum(std::size_t pixel, const SpectralSample& sample) {
    double* bins = spectra_.data() + pixel * static_cast<std::size_t>(spectral_bins_);
    for (int k = 0; k < 4; ++k) bins[sample.bin[k]] += static_cast<double>(sample.value[k]);
  }

  int frame_width_ = 0, frame_height_ = 0;
  PixelRect crop_;
  FilmLayout layout_;
  std::vector<std::uint8_t> has_variance_;  ///< of each channel
  std::size_t variances_ = 0;               ///< channels that have one
  int spectral_bins_ = 0;
  std::vector<std::uint64_t> counts_;  ///< per pixel
  std::vector<double> sums_;           ///< per pixel and channel
  std::vector<double> squares_;        ///< sums of squares, per pixel and channel with a variance
  std::vector<double> spectra_;        ///< sums, per pixel and bin
};

}  // namespace sheaf

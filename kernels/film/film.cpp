#include "kernels/film/film.h"

#include "core/color.h"

#include <algorithm>
#include <limits>
#include <string>

namespace sheaf {

namespace {

/// Variances of very bright pixels stay finite in single precision.
constexpr double kLargest = std::numeric_limits<float>::max();

/// Width of a bin, nm.
double bin_width(int bins) { return static_cast<double>(kWavelengthMax - kWavelengthMin) / bins; }

/// The channel of a bin: its centre with six decimals after a comma.
std::string bin_channel(int bin, int bins) {
  std::string centre = std::to_string(static_cast<double>(kWavelengthMin) + (bin + 0.5) * bin_width(bins));
  std::replace(centre.begin(), centre.end(), '.', ',');
  return "S0." + centre + "nm";
}

/// The unbiased variance of the mean of n samples, by their sum and the sum of their squares.
float variance_of_mean(double sum, double sum_of_squares, double n) {
  if (n < 2.0) return 0.0f;
  const double mean = sum / n;
  return static_cast<float>(std::min(std::max(0.0, sum_of_squares / n - mean * mean) / (n - 1.0), kLargest));
}

}  // namespace

Film::Film(int frame_width, int frame_height, PixelRect crop, FilmLayout layout, int spectral_bins)
    : frame_width_(frame_width),
      frame_height_(frame_height),
      crop_(crop),
      layout_(std::move(layout)),
      variances_(static_cast<std::size_t>(layout_.variance_count())),
      spectral_bins_(spectral_bins),
      counts_(static_cast<std::size_t>(crop.width()) * static_cast<std::size_t>(crop.height())),
      sums_(counts_.size() * static_cast<std::size_t>(layout_.size())),
      squares_(counts_.size() * variances_),
      spectra_(counts_.size() * static_cast<std::size_t>(spectral_bins)) {
  for (const FilmChannel& channel : layout_.channels()) has_variance_.push_back(channel.has_variance);
}

Image Film::to_image() const {
  std::vector<std::string> names;
  for (const FilmChannel& channel : layout_.channels()) names.push_back(channel.name);
  for (const FilmChannel& channel : layout_.channels())
    if (channel.has_variance) names.push_back("variance." + channel.name);
  names.emplace_back("sampleCount");
  for (int bin = 0; bin < spectral_bins_; ++bin) names.push_back(bin_channel(bin, spectral_bins_));
  Image image(crop_.width(), crop_.height(), std::move(names));
  image.x0 = crop_.x0;
  image.y0 = crop_.y0;
  image.frame_width = frame_width_;
  image.frame_height = frame_height_;
  const std::size_t channels = has_variance_.size(), bins = static_cast<std::size_t>(spectral_bins_);
  for (std::size_t pixel = 0; pixel < counts_.size(); ++pixel) {
    if (counts_[pixel] == 0) continue;
    const auto n = static_cast<double>(counts_[pixel]);
    float* mean = image.data.data() + pixel * image.channels.size();
    float* variance = mean + channels;
    const double* sum = sums_.data() + pixel * channels;
    const double* square = squares_.data() + pixel * variances_;
    for (std::size_t c = 0; c < channels; ++c) {
      mean[c] = static_cast<float>(sum[c] / n);
      if (has_variance_[c]) *variance++ = variance_of_mean(sum[c], *square++, n);
    }
    *variance = static_cast<float>(n);
    for (std::size_t bin = 0; bin < bins; ++bin)
      variance[1 + bin] = static_cast<float>(spectra_[pixel * bins + bin] / (n * bin_width(spectral_bins_)));
  }
  return image;
}

}  // namespace sheaf

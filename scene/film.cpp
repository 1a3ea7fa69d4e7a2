#include "scene/film.h"

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

}  // namespace

Film::Film(int frame_width, int frame_height, PixelRect crop, int spectral_bins)
    : frame_width_(frame_width),
      frame_height_(frame_height),
      crop_(crop),
      pixels_(static_cast<std::size_t>(crop.width()) * static_cast<std::size_t>(crop.height())),
      spectral_bins_(spectral_bins),
      spectra_(pixels_.size() * static_cast<std::size_t>(spectral_bins)) {}

Image Film::to_image() const {
  std::vector<std::string> channels{"R", "G", "B", "A", "variance.R", "variance.G", "variance.B", "sampleCount"};
  const std::size_t first_bin = channels.size(), bins = static_cast<std::size_t>(spectral_bins_);
  for (int bin = 0; bin < spectral_bins_; ++bin) channels.push_back(bin_channel(bin, spectral_bins_));
  Image image(crop_.width(), crop_.height(), std::move(channels));
  image.x0 = crop_.x0;
  image.y0 = crop_.y0;
  image.frame_width = frame_width_;
  image.frame_height = frame_height_;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& p = pixels_[i];
    if (p.count == 0) continue;
    float* out = image.data.data() + i * image.channels.size();
    const auto n = static_cast<double>(p.count);
    for (std::size_t c = 0; c < 3; ++c) {
      const double mean = p.sum[c] / n;
      out[c] = static_cast<float>(mean);
      const double variance = std::max(0.0, p.sum_of_squares[c] / n - mean * mean) / (n - 1.0);
      if (p.count > 1) out[4 + c] = static_cast<float>(std::min(variance, kLargest));
    }
    out[3] = static_cast<float>(p.alpha / n);
    out[7] = static_cast<float>(p.count);
    for (std::size_t bin = 0; bin < bins; ++bin)
      out[first_bin + bin] = static_cast<float>(spectra_[i * bins + bin] / (n * bin_width(spectral_bins_)));
  }
  return image;
}

}  // namespace sheaf

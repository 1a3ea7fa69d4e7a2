#include "kernels/film/noise.h"

#include <algorithm>
#include <numeric>

namespace sheaf {

double mean_but_worst(std::vector<double>& values) {
  constexpr double kWorst = 1e-3;
  const auto kept = static_cast<std::ptrdiff_t>(static_cast<double>(values.size()) * (1 - kWorst));
  if (kept == 0) return 0.0;
  std::nth_element(values.begin(), values.begin() + kept, values.end());
  return std::accumulate(values.begin(), values.begin() + kept, 0.0) / static_cast<double>(kept);
}

void ImageNoise::add(const float* value, const float* variance) {
  double of_value = 0, of_variance = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    of_value += kLuminance[c] * static_cast<double>(value[c]);
    // Assume that the errors of the components are fully correlated, which holds unless the light is strongly colored.
    of_variance += kLuminance[c] * std::sqrt(static_cast<double>(variance[c]));
  }
  values_.push_back(of_value);
  relative_.push_back(of_variance * of_variance);
  sum_ += of_value;
}

double ImageNoise::noise() {
  const double mean = sum_ / static_cast<double>(std::max<std::size_t>(values_.size(), 1));
  for (std::size_t pixel = 0; pixel < values_.size(); ++pixel)
    relative_[pixel] = relative_square(values_[pixel], relative_[pixel], mean);
  return std::sqrt(mean_but_worst(relative_));
}

std::optional<double> image_noise(const Image& image) {
  constexpr const char* kNames[] = {"R", "G", "B"};
  // Find the channels
  int values[3], variances[3];
  for (std::size_t c = 0; c < 3; ++c) {
    values[c] = image.find_channel(kNames[c]);
    variances[c] = image.find_channel(std::string("variance.") + kNames[c]);
    if (values[c] < 0 || variances[c] < 0) return std::nullopt;
  }
  // Accumulate the noise of all pixels
  ImageNoise noise;
  const int count = image.find_channel("sampleCount");
  std::size_t unknown = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      float value[3], variance[3];
      for (std::size_t c = 0; c < 3; ++c) {
        value[c] = image.at(x, y, values[c]);
        variance[c] = image.at(x, y, variances[c]);
      }
      noise.add(value, variance);
      if (count >= 0 && image.at(x, y, count) < 2.0f) ++unknown;
    }
  if (is_noise_unknown(unknown, image.pixel_count())) return std::nullopt;
  return noise.noise();
}

}  // namespace sheaf

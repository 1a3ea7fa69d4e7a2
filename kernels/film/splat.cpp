#include "kernels/film/splat.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace sheaf {

namespace {

/// The filter's integral along one axis, by the midpoint rule.
double filter_integral(const FilterDescription& filter) {
  constexpr int kSteps = 1 << 16;
  const double radius = filter_radius(filter), width = 2.0 * radius / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += evaluate_filter(filter, (i + 0.5) * width - radius);
  return sum * width;
}

/// Rows that one thread adds splats to at a time; each looks at all splats.
constexpr int kBand = 64;

}  // namespace

SplatFilm::SplatFilm(PixelRect crop, const FilterDescription& filter)
    : crop_(crop),
      filter_(filter),
      radius_(filter_radius(filter)),
      scale_(1.0 / filter_integral(filter)),
      sums_(3 * static_cast<std::size_t>(crop.width()) * static_cast<std::size_t>(crop.height())),
      squares_(sums_.size()) {}

void SplatFilm::add_row(int y, const Splat& splat) {
  const double weight_y = evaluate_filter(filter_, y + 0.5 - static_cast<double>(splat.y)) * scale_;
  const double from = static_cast<double>(splat.x) - 0.5 - radius_, to = static_cast<double>(splat.x) - 0.5 + radius_;
  const int x0 = std::max(crop_.x0, static_cast<int>(std::ceil(from)));
  const int x1 = std::min(crop_.x1 - 1, static_cast<int>(std::floor(to)));
  for (int x = x0; x <= x1; ++x) {
    const double weight = weight_y * evaluate_filter(filter_, x + 0.5 - static_cast<double>(splat.x)) * scale_;
    const std::size_t at = 3 * (static_cast<std::size_t>(y - crop_.y0) * static_cast<std::size_t>(crop_.width()) +
                                static_cast<std::size_t>(x - crop_.x0));
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = weight * static_cast<double>(splat.rgb[c]);
      sums_[at + c] += value;
      squares_[at + c] += value * value;
    }
  }
}

void SplatFilm::add(std::span<const std::vector<Splat>> tasks) {
  const int bands = (crop_.height() + kBand - 1) / kBand;
  tbb::parallel_for(tbb::blocked_range<int>(0, bands, 1), [&](const tbb::blocked_range<int>& range) {
    const int first = crop_.y0 + range.begin() * kBand, last = std::min(crop_.y1, crop_.y0 + range.end() * kBand) - 1;
    for (const std::vector<Splat>& task : tasks)
      for (const Splat& splat : task) {
        const double at = static_cast<double>(splat.y) - 0.5;
        const int y0 = std::max(first, static_cast<int>(std::ceil(at - radius_)));
        const int y1 = std::min(last, static_cast<int>(std::floor(at + radius_)));
        for (int y = y0; y <= y1; ++y) add_row(y, splat);
      }
  });
}

void SplatFilm::add_to(Image& image, std::uint64_t photons) const {
  if (photons == 0) return;
  const auto n = static_cast<double>(photons);
  const char* const names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    const int mean_channel = image.find_channel(names[c]);
    const int variance_channel = image.find_channel(std::string("variance.") + names[c]);
    for (std::size_t pixel = 0; pixel < sums_.size() / 3; ++pixel) {
      const double mean = sums_[3 * pixel + c] / n;
      const double variance = std::max(0.0, squares_[3 * pixel + c] / n - mean * mean) / std::max(1.0, n - 1.0);
      float* out = image.data.data() + pixel * image.channels.size();
      if (mean_channel >= 0) out[mean_channel] += static_cast<float>(mean);
      if (variance_channel >= 0) out[variance_channel] += static_cast<float>(variance);
    }
  }
}

}  // namespace sheaf

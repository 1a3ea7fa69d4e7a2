#include "kernels/film/splat.h"

#include "core/simd/lanes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace sheaf {

namespace {

/// Rows of pixels per parallel work item; each work item visits all splats.
constexpr int kRowsPerBand = 64;

}  // namespace

namespace {

/// Integrals of the values of FilterWeights::across() over all offsets of a sample in its pixel. The values are linear
/// within each step and end at the radius, so the midpoint rule is exact.
std::vector<double> filter_integrals(const FilterWeights& weights, double radius) {
  constexpr int kSteps = 1024;  // a multiple of FilterWeights::kSteps
  std::vector<double> integrals(static_cast<std::size_t>(2 * weights.reach() + 1));
  std::array<double, FilterWeights::kMaxPixels> values;
  for (std::size_t k = 0; k < integrals.size(); ++k)
    for (int step = 0; step < kSteps; ++step) {
      const double center = static_cast<double>(k) - weights.reach();
      const double begin = std::max(static_cast<double>(step) / kSteps - 0.5, center - radius);
      const double end = std::min(static_cast<double>(step + 1) / kSteps - 0.5, center + radius);
      if (!(begin < end)) continue;
      weights.across(static_cast<float>(0.5 * (begin + end)), values.data());
      integrals[k] += (end - begin) * values[k];
    }
  return integrals;
}

}  // namespace

SplatFilter::SplatFilter(const PixelFilter& filter, FilterMode mode, const PixelRect& sampled, float panorama_width)
    : weights_(filter),
      sampled_(sampled),
      is_weighted_(mode == FilterMode::kWeighted),
      panorama_width_(panorama_width),
      cumulative_{0.0} {
  for (const double integral : filter_integrals(weights_, filter_radius(filter)))
    cumulative_.push_back(cumulative_.back() + integral);
}

SplatFilter::Bounds SplatFilter::bounds(const PixelRect& crop) const {
  PixelRect pixels = crop.grown(weights_.reach());
  if (is_weighted_) pixels = pixels.intersection(sampled_);
  if (panorama_width_ > 0) return {-kInfinity, static_cast<float>(pixels.y0), kInfinity, static_cast<float>(pixels.y1)};
  return {static_cast<float>(pixels.x0), static_cast<float>(pixels.y0), static_cast<float>(pixels.x1),
          static_cast<float>(pixels.y1)};
}

double SplatFilter::integral(int at, int sampled_begin, int sampled_end) const {
  if (!is_weighted_) return cumulative_.back();
  // The offset from a sampled pixel q to the pixel `at` is at - q.
  const int reach = weights_.reach();
  const int first = std::clamp(at - (sampled_end - 1), -reach, reach + 1) + reach;
  const int last = std::clamp(at - sampled_begin, -reach - 1, reach) + reach;
  return cumulative_[static_cast<std::size_t>(last + 1)] - cumulative_[static_cast<std::size_t>(first)];
}

SplatFilter::Span SplatFilter::span(float at, int begin, int end, int sampled_begin, int sampled_end) const {
  const int own = static_cast<int>(std::floor(at)), reach = weights_.reach();
  Span out;
  if (is_weighted_ && (own < sampled_begin || own >= sampled_end)) return out;
  out.first = std::max(own - reach, begin);
  out.count = std::max(std::min(own + reach + 1, end) - out.first, 0);
  out.skipped = out.first - (own - reach);
  weights_.across(at - static_cast<float>(own) - 0.5f, out.weights.data());
  for (int i = 0; i < out.count; ++i)
    out.weights[static_cast<std::size_t>(out.skipped + i)] /= integral(out.first + i, sampled_begin, sampled_end);
  return out;
}

SplatFilm::SplatFilm(PixelRect crop)
    : crop_(crop),
      sums_(3 * static_cast<std::size_t>(crop.width()) * static_cast<std::size_t>(crop.height())),
      squares_(sums_.size()) {}

void SplatFilm::add(std::span<const std::vector<Splat>> tasks, const SplatFilter& filter) {
  // Add a splat to the pixels under the filter
  const auto add_at = [&](const Splat& splat, float x, const SplatFilter::Span& down) {
    const SplatFilter::Span across = filter.across(x, crop_.x0, crop_.x1);
    for (int j = 0; j < down.count; ++j)
      for (int i = 0; i < across.count; ++i) {
        const double weight = across.weight(i) * down.weight(j);
        const auto row = static_cast<std::size_t>(down.first + j - crop_.y0);
        const auto column = static_cast<std::size_t>(across.first + i - crop_.x0);
        const std::size_t at = 3 * (row * static_cast<std::size_t>(crop_.width()) + column);
        for (std::size_t c = 0; c < 3; ++c) {
          const double value = weight * static_cast<double>(splat.rgb[c]);
          sums_[at + c] += value;
          squares_[at + c] += value * value;
        }
      }
  };
  // Add a splat to a band, also across the seam of panoramic cameras
  const auto add_splat = [&](const Splat& splat, int begin, int end) {
    const SplatFilter::Span down = filter.down(splat.y, begin, end);
    if (down.count == 0) return;
    add_at(splat, splat.x, down);
    for (int k = 1; k <= filter.wraps(); ++k)
      for (const int sign : {-1, 1})
        add_at(splat, splat.x + static_cast<float>(sign * k) * filter.panorama_width(), down);
  };
  // Add all splats to each band, in the order of tasks
  const int bands = (crop_.height() + kRowsPerBand - 1) / kRowsPerBand;
  tbb::parallel_for(tbb::blocked_range<int>(0, bands, 1), [&](const tbb::blocked_range<int>& range) {
    const int first = crop_.y0 + range.begin() * kRowsPerBand,
              end = std::min(crop_.y1, crop_.y0 + range.end() * kRowsPerBand);
    for (const std::vector<Splat>& task : tasks)
      for (const Splat& splat : task) add_splat(splat, first, end);
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

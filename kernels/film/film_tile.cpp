#include "kernels/film/film_tile.h"

#include "core/simd/simd.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace sheaf {

namespace {

/// Maximum number of samples that add_together() adds at once.
constexpr std::size_t kMaxSamplesAtOnce = 16;

/// The pixels in [begin, end) within a sample's reach along one axis, and the weights of all pixels within reach.
struct Span {
  int first = 0, count = 0;
  int skipped = 0;  ///< pixels within reach before the first one
  /// Not initialized: only the first length() weights of the filter are used.
  std::array<double, FilterWeights::kMaxPixels> weights;

  Span(const FilterWeights& filter, int at, float offset, int begin, int end)
      : first(std::max(at - filter.reach(), begin)),
        count(std::max(std::min(at + filter.reach() + 1, end) - first, 0)),
        skipped(first - (at - filter.reach())) {
    filter.across(offset, weights.data());
  }
  double weight(int i) const { return weights[static_cast<std::size_t>(skipped + i)]; }
};

constexpr std::size_t kRegister = FilmRow::kRegister;
static_assert(kRegister == FilterWeights::kRegister);

/// One register of a row. Without explicit vectors, compilers vectorize these loops across pixels instead of across
/// numbers.
using RowRegister [[gnu::vector_size(kRegister * sizeof(double))]] = double;

/// One register of the terms of several samples, with a row of weights along each axis.
struct Weighed {
  const double* terms;   ///< of the first sample; `stride` numbers between samples
  const double* across;  ///< of the first sample; kRegister numbers between samples
  const double* down;    ///< like across
  std::size_t stride, count;
};

/// Adds samples to kPixels adjacent pixels. Keeps the pixels' sums in registers.
template <std::size_t kPixels> SHEAF_INLINE void add_to_pixels(const Weighed& samples, double* sums) {
  RowRegister sum[kPixels];
  for (std::size_t i = 0; i < kPixels; ++i) std::memcpy(&sum[i], sums + i * samples.stride, sizeof sum[i]);
  const double* terms = samples.terms;
  const double* across = samples.across;
  const double* down = samples.down;
  for (std::size_t k = 0; k < samples.count; ++k, terms += samples.stride, across += kRegister, down += kRegister) {
    RowRegister term;
    std::memcpy(&term, terms, sizeof term);
    term *= *down;
    for (std::size_t i = 0; i < kPixels; ++i) sum[i] = across[i] * term + sum[i];
  }
  for (std::size_t i = 0; i < kPixels; ++i) std::memcpy(sums + i * samples.stride, &sum[i], sizeof sum[i]);
}

/// Adds samples to any number of adjacent pixels.
void add_to_line(Weighed samples, double* sums, int pixels) {
  constexpr int kMax = 5;  // width of filters of radius 2
  for (; pixels >= kMax; pixels -= kMax, samples.across += kMax, sums += kMax * samples.stride)
    add_to_pixels<kMax>(samples, sums);
  if (pixels == 4) return add_to_pixels<4>(samples, sums);
  if (pixels == 3) return add_to_pixels<3>(samples, sums);
  if (pixels == 2) return add_to_pixels<2>(samples, sums);
  if (pixels == 1) return add_to_pixels<1>(samples, sums);
}

}  // namespace

void FilmTile::begin(const FilmRow& row, const FilterWeights* weights, const PixelRect& own, const PixelRect& crop,
                     bool has_surface_ids) {
  row_ = row;
  weights_ = weights;
  own_ = own.intersection(crop);
  outer_ = own.grown(weights != nullptr ? weights->reach() : 0).intersection(crop);
  const auto pixels = static_cast<std::size_t>(outer_.width()) * static_cast<std::size_t>(outer_.height());
  sums_.assign(pixels * row_.size(), 0.0);
  counts_.assign(pixels, 0);
  coverage_.assign(has_surface_ids ? pixels : 0, {});
  terms_.assign(kMaxSamplesAtOnce * row_.bins_at, 0.0);
}

void FilmTile::take(const float* sample, double* terms) const {
  terms[FilmRow::kWeight] = 1.0;
  for (std::size_t c = 0; c < row_.channels; ++c) terms[FilmRow::kSums + c] = sample[c];
  if (row_.tile_squares == 0) return;
  double* square = terms + row_.weight_squared;
  *square++ = 1.0;
  for (const std::size_t c : row_.with_variance) {
    const double value = sample[c];
    *square++ = value * value;
    *square++ = value;
  }
}

void FilmTile::add_weighted(double* row, double weight) const {
  // Rows and terms do not alias; the compiler needs this to keep values in registers.
  const auto add = [](double* __restrict sums, const double* __restrict terms, std::size_t count, double factor) {
    for (std::size_t k = 0; k < count; k += FilmRow::kRegister)
      for (std::size_t lane = k; lane < k + FilmRow::kRegister; ++lane) sums[lane] += factor * terms[lane];
  };
  const std::size_t first = row_.weight_squared;
  add(row, terms_.data(), first, weight);
  add(row + first, terms_.data() + first, row_.bins_at - first, weight * weight);
}

void FilmTile::cover(int x, int y, const SurfaceSample& surface, double weight) {
  coverage_[index(x, y)].add(surface.shape, weights_ != nullptr ? weight : static_cast<double>(surface.weight));
}

void FilmTile::add(int x, int y, const SampleBuffer& samples, std::size_t first, std::size_t count) {
  const bool has_sums_alone = row_.bins == 0 && row_.tile_squares == 0 && !has_surface_ids();
  if (weights_ != nullptr && has_sums_alone && weights_->length() == static_cast<int>(kRegister)) {
    for (std::size_t k = 0; k < count; k += kMaxSamplesAtOnce)
      add_together(x, y, samples, first + k, std::min(kMaxSamplesAtOnce, count - k));
    return;
  }
  for (std::size_t k = 0; k < count; ++k)
    if (!samples.is_dropped(first + k)) add_alone(x, y, samples, first + k);
}

void FilmTile::add_together(int x, int y, const SampleBuffer& samples, std::size_t first, std::size_t count) {
  const int reach = weights_->reach();
  const PixelRect reached = PixelRect{x - reach, y - reach, x + reach + 1, y + reach + 1}.intersection(outer_);
  if (reached.is_empty()) return;
  // Not initialized: that would take as long as the rest of the function.
  alignas(kSimdAlignment) double across[kMaxSamplesAtOnce * kRegister], down[kMaxSamplesAtOnce * kRegister];
  const std::size_t stride = row_.size();
  // Collect the terms of the samples and their weights along both axes.
  std::size_t taken = 0;
  for (std::size_t k = first; k < first + count; ++k) {
    if (samples.is_dropped(k)) continue;
    const SampleOffset offset = samples.offset(k);
    weights_->across(offset.x, across + taken * kRegister);
    weights_->across(offset.y, down + taken * kRegister);
    take(samples[k], terms_.data() + taken * stride);
    ++taken;
  }
  if (is_own(x, y)) counts_[index(x, y)] += static_cast<std::uint32_t>(taken);
  // Add them to all pixels within reach, register by register.
  for (std::size_t part = 0; part < stride; part += kRegister)
    for (int to_y = reached.y0; to_y < reached.y1; ++to_y)
      add_to_line({terms_.data() + part, across + (reached.x0 - x + reach), down + (to_y - y + reach), stride, taken},
                  sums_.data() + index(reached.x0, to_y) * stride + part, reached.width());
}

void FilmTile::add_alone(int x, int y, const SampleBuffer& samples, std::size_t sample) {
  if (is_own(x, y)) ++counts_[index(x, y)];
  take(samples[sample], terms_.data());
  const auto add_to = [&](int to_x, int to_y, double weight) {
    double* const row = sums_.data() + index(to_x, to_y) * row_.size();
    add_weighted(row, weight);
    if (has_surface_ids()) cover(to_x, to_y, samples.surface(sample), weight);
    if (row_.bins == 0) return;
    const SpectralSample& spectrum = samples.spectrum(sample);
    for (int k = 0; k < 4; ++k) row[row_.bins_at + spectrum.bin[k]] += weight * static_cast<double>(spectrum.value[k]);
  };
  if (weights_ == nullptr) {
    if (is_own(x, y)) add_to(x, y, 1.0);
    return;
  }
  const SampleOffset offset = samples.offset(sample);
  const Span across(*weights_, x, offset.x, outer_.x0, outer_.x1), down(*weights_, y, offset.y, outer_.y0, outer_.y1);
  for (int j = 0; j < down.count; ++j)
    for (int i = 0; i < across.count; ++i)
      if (const double weight = across.weight(i) * down.weight(j); weight != 0.0)
        add_to(across.first + i, down.first + j, weight);
}

FilmBorder FilmTile::border() const {
  FilmBorder border;
  const auto add_strip = [&](const PixelRect& pixels) {
    if (pixels.is_empty()) return;
    FilmBorder::Strip strip{pixels, {}, {}};
    for (int y = pixels.y0; y < pixels.y1; ++y)
      for (int x = pixels.x0; x < pixels.x1 && has_surface_ids(); ++x) strip.coverage.push_back(coverage(x, y));
    for (int y = pixels.y0; y < pixels.y1; ++y)
      strip.sums.insert(strip.sums.end(), row(pixels.x0, y),
                        row(pixels.x0, y) + static_cast<std::size_t>(pixels.width()) * row_.size());
    border.strips.push_back(std::move(strip));
  };
  if (own_.is_empty()) {
    add_strip(outer_);
    return border;
  }
  add_strip({outer_.x0, outer_.y0, outer_.x1, own_.y0});
  add_strip({outer_.x0, own_.y0, own_.x0, own_.y1});
  add_strip({own_.x1, own_.y0, outer_.x1, own_.y1});
  add_strip({outer_.x0, own_.y1, outer_.x1, outer_.y1});
  return border;
}

}  // namespace sheaf

#include "kernels/film/film_tile.h"

#include "core/simd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace sheaf {

namespace {

/// The pixels along an axis in which a sample counts, and how much.
struct Span {
  int first = 0, count = 0;
  const double* weights = nullptr;
  // Not initialised: only `count` of them, from `weights` on, are used.
  std::array<double, FilterWeights::kMostPixels> all;
};

/// `at`: the sample's pixel; `offset`: from its centre; [begin, end): pixels that are of interest.
void weigh(const FilterWeights& filter, int at, float offset, int begin, int end, Span& out) {
  const int before = std::max(static_cast<int>(std::ceil(offset - filter.radius())), -filter.reach());
  const int after = std::min(static_cast<int>(std::floor(offset + filter.radius())), filter.reach());
  out.first = std::max(at + before, begin);
  out.count = std::max(std::min(at + after + 1, end) - out.first, 0);
  if (out.count == 0) return;
  filter.across(offset, out.all.data());
  out.weights = out.all.data() + (out.first - at + filter.reach());
}

/// One register of a row. Compilers that are left alone with loops over these numbers put pixels across registers.
using RowRegister [[gnu::vector_size(FilmRow::kRegister * sizeof(double))]] = double;

/// Adds one register of terms to the rows of all pixels that a sample reaches, of which each is one register, and a
/// line of pixels `stride` of them.
void add_register(double* __restrict sums, std::size_t stride, const double* __restrict terms, const Span& across,
                  const Span& down) {
  const int width = across.count, height = down.count;
  const double* __restrict const weights = across.weights;
  const double* __restrict const line_weights = down.weights;
  RowRegister term;
  std::memcpy(&term, terms, sizeof term);
  for (int j = 0; j < height; ++j, sums += stride * FilmRow::kRegister) {
    const RowRegister of_line = term * line_weights[j];
    const auto add = [&](int i) SHEAF_LAMBDA_INLINE {
      double* const at = sums + static_cast<std::size_t>(i) * FilmRow::kRegister;
      RowRegister sum;
      std::memcpy(&sum, at, sizeof sum);
      sum += weights[i] * of_line;
      std::memcpy(at, &sum, sizeof sum);
    };
    int i = 0;
    for (; i + 4 <= width; i += 4) add(i), add(i + 1), add(i + 2), add(i + 3);
    for (; i < width; ++i) add(i);
  }
}

}  // namespace

void FilmTile::begin(const FilmRow& row, const FilterWeights* weights, const PixelRect& own, const PixelRect& crop,
                     bool tells_surfaces) {
  row_ = row;
  weights_ = weights;
  own_ = own.intersection(crop);
  outer_ = own.grown(weights != nullptr ? weights->reach() : 0).intersection(crop);
  const auto pixels = static_cast<std::size_t>(outer_.width()) * static_cast<std::size_t>(outer_.height());
  sums_.assign(pixels * row_.size(), 0.0);
  counts_.assign(pixels, 0);
  coverage_.assign(tells_surfaces ? pixels : 0, {});
  terms_.assign(row_.bins_at, 0.0);
}

/// Fills terms_.
void FilmTile::take(const float* sample) {
  terms_[FilmRow::kWeight] = 1.0;
  for (std::size_t c = 0; c < row_.channels; ++c) terms_[FilmRow::kSums + c] = sample[c];
  if (row_.tile_squares == 0) return;
  double* square = terms_.data() + row_.weight_squared;
  *square++ = 1.0;
  for (const std::size_t c : row_.with_variance) {
    const double value = sample[c];
    *square++ = value * value;
    *square++ = value;
  }
}

void FilmTile::add_weighted(double* row, double weight) const {
  // Rows and terms are different memory, which registers need to know.
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

void FilmTile::add(int x, int y, const SampleBuffer& samples, std::size_t index_of_sample) {
  if (samples.is_dropped(index_of_sample)) return;
  const bool is_own = x >= own_.x0 && x < own_.x1 && y >= own_.y0 && y < own_.y1;
  if (is_own) ++counts_[index(x, y)];
  take(samples[index_of_sample]);
  const auto add_to = [&](int to_x, int to_y, double weight) {
    double* const row = sums_.data() + index(to_x, to_y) * row_.size();
    add_weighted(row, weight);
    if (tells_surfaces()) cover(to_x, to_y, samples.surface(index_of_sample), weight);
    if (row_.bins == 0) return;
    const SpectralSample& spectrum = samples.spectrum(index_of_sample);
    for (int k = 0; k < 4; ++k) row[row_.bins_at + spectrum.bin[k]] += weight * static_cast<double>(spectrum.value[k]);
  };
  if (weights_ == nullptr) {
    if (is_own) add_to(x, y, 1.0);
    return;
  }
  const SampleOffset offset = samples.offset(index_of_sample);
  Span across, down;
  weigh(*weights_, x, offset.x, outer_.x0, outer_.x1, across);
  weigh(*weights_, y, offset.y, outer_.y0, outer_.y1, down);
  if (across.count == 0 || down.count == 0) return;
  if (row_.size() == FilmRow::kRegister && !tells_surfaces()) {
    add_register(sums_.data() + index(across.first, down.first) * FilmRow::kRegister,
                 static_cast<std::size_t>(outer_.width()), terms_.data(), across, down);
    return;
  }
  for (int j = 0; j < down.count; ++j)
    for (int i = 0; i < across.count; ++i)
      add_to(across.first + i, down.first + j, across.weights[i] * down.weights[j]);
}

FilmBorder FilmTile::border() const {
  FilmBorder border;
  const auto add_strip = [&](const PixelRect& pixels) {
    if (pixels.is_empty()) return;
    FilmBorder::Strip strip{pixels, {}, {}};
    for (int y = pixels.y0; y < pixels.y1; ++y)
      for (int x = pixels.x0; x < pixels.x1 && tells_surfaces(); ++x) strip.coverage.push_back(coverage(x, y));
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

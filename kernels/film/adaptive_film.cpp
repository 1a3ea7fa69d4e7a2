#include "kernels/film/adaptive_film.h"

#include "kernels/film/noise.h"

#include <algorithm>
#include <bit>

namespace sheaf {

namespace {

/// Samples of a half, per pixel, below which no tile is content: fewer do not tell noise.
constexpr std::uint32_t kLeastSamples = 16;
constexpr std::uint32_t kFirstSamples = 2;

/// How many samples come next: units of powers of two, which samplers spread best, and several of similar size, which
/// tell the variance.
std::uint32_t next_samples(std::uint32_t taken) { return std::max(kFirstSamples, std::bit_floor(taken / 2)); }

/// Numbers of a pixel's luminance: sums of W_u, Y_u, W_u^2, Y_u^2 and W_u Y_u over the units.
constexpr std::size_t kLuminanceSums = 5;

std::size_t index_in(const PixelRect& rect, int x, int y) {
  return static_cast<std::size_t>(y - rect.y0) * static_cast<std::size_t>(rect.width()) +
         static_cast<std::size_t>(x - rect.x0);
}

/// f(x, y) for all pixels, row by row.
template <class F> void for_each_pixel(const PixelRect& rect, F&& f) {
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x) f(x, y);
}

}  // namespace

AdaptiveFilm::AdaptiveFilm(const Film& film, const std::vector<PixelRect>& tiles, int reach, AdaptiveGoal goal)
    : row_(film.row_), goal_(goal), reach_(reach), tiles_(tiles.size()), expected_(tiles.size(), goal.max_samples) {
  for (std::size_t c = 0; c < row_.channels; ++c)
    if (film.layout().channels()[c].has_half) halved_.push_back(c);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    Tile& tile = tiles_[i];
    tile.square = tiles[i];
    tile.own = tiles[i].intersection(film.crop());
    tile.outer = tiles[i].grown(reach).intersection(film.crop());
    for (Half& half : tile.halves) {
      half.sums.resize(tile.outer.area() * row_size());
      half.counts.resize(tile.own.area());
      if (film.tells_surfaces()) half.coverage.resize(tile.outer.area());
      half.luminance.resize(tile.judged().area() * kLuminanceSums);
    }
  }
}

bool AdaptiveFilm::begin_round() {
  const auto is_left = [](const AdaptiveUnit& unit) { return unit.done == 0; };
  if (std::any_of(units_.begin(), units_.end(), is_left)) return true;
  if (!units_.empty()) ++rounds_;
  units_.clear();
  const std::uint32_t most = goal_.max_samples / 2;
  const double means[2] = {mean_luminance(0), mean_luminance(1)}, wanted = 2 * goal_.noise * goal_.noise;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    Tile& tile = tiles_[i];
    if (tile.is_content()) continue;
    const std::uint32_t taken = tile.halves[0].samples, next = std::min(next_samples(taken), most - taken);
    double expected = 0;
    for (int h = 0; h < 2; ++h) {
      Half& half = tile.halves[h];
      const double noise = wanted > 0 && taken >= kLeastSamples ? noise_squared(half, means[h]) : -1;
      half.content = half.content || taken >= most || (noise >= 0 && noise <= wanted);
      expected += std::clamp(noise >= 0 ? taken * noise / wanted : double(most), double(taken), double(most));
    }
    expected_[i] = tile.is_content() ? 2.0 * taken : std::max(expected, 2.0 * (taken + next));
    if (tile.is_content()) continue;
    for (std::uint8_t h = 0; h < 2; ++h) units_.push_back({static_cast<std::uint32_t>(i), next, tile.units++, h, 0});
  }
  return !units_.empty();
}

void AdaptiveFilm::add(std::size_t unit, const FilmTile& samples) {
  AdaptiveUnit& u = units_[unit];
  Tile& tile = tiles_[u.tile];
  Half& half = tile.halves[u.half];
  if (!tile.halves[1 - u.half].content) add_sums(tile, half, u, samples);
  if (!half.content) add_luminance(tile, half, samples);
  half.samples += u.samples;
  u.done = 1;
}

void AdaptiveFilm::add_sums(const Tile& tile, Half& half, const AdaptiveUnit& unit, const FilmTile& samples) const {
  const double n = unit.samples;
  for_each_pixel(tile.outer, [&](int x, int y) {
    const double* const from = samples.row(x, y);
    const std::size_t pixel = index_in(tile.outer, x, y);
    double* to = half.sums.data() + pixel * row_size();
    const double w = from[FilmRow::kWeight];
    *to++ += w;
    for (std::size_t c = 0; c < row_.channels; ++c) *to++ += from[FilmRow::kSums + c];
    *to++ += w * w;
    *to++ += w * n;
    for (const std::size_t c : row_.with_variance) {
      const double s = from[FilmRow::kSums + c];
      *to++ += s * s;
      *to++ += s * w;
      *to++ += s * n;
    }
    for (std::size_t bin = 0; bin < row_.bins; ++bin) *to++ += from[row_.bins_at + bin];
    if (!half.coverage.empty()) half.coverage[pixel].add(samples.coverage(x, y));
  });
  for_each_pixel(tile.own, [&](int x, int y) { half.counts[index_in(tile.own, x, y)] += samples.count(x, y); });
  half.used += unit.samples;
  half.used_squares += n * n;
}

void AdaptiveFilm::add_luminance(const Tile& tile, Half& half, const FilmTile& samples) {
  double* to = half.luminance.data();
  for_each_pixel(tile.judged(), [&](int x, int y) {
    const double* const from = samples.row(x, y);
    const double w = from[FilmRow::kWeight], value = luminance_of(from + FilmRow::kSums);
    for (const double term : {w, value, w * w, value * value, w * value}) *to++ += term;
  });
}

double AdaptiveFilm::mean_luminance(int half) const {
  double weight = 0, value = 0;
  for (const Tile& tile : tiles_) {
    const Half& h = tile.halves[half];
    if (h.samples == 0) continue;
    for (std::size_t i = 0; i < h.luminance.size(); i += kLuminanceSums) {
      weight += h.luminance[i] / h.samples;
      value += h.luminance[i + 1] / h.samples;
    }
  }
  return weight > 0 ? value / weight : 0.0;
}

double AdaptiveFilm::noise_squared(const Half& half, double mean_luminance) {
  std::vector<double> relative;
  for (std::size_t i = 0; i < half.luminance.size(); i += kLuminanceSums) {
    const double* const s = half.luminance.data() + i;
    if (!(s[0] > 0)) continue;
    const double mean = s[1] / s[0];
    relative.push_back(relative_square(mean, variance_of_mean(mean, s[0], s[2], s[3], s[4]), mean_luminance));
  }
  return mean_but_worst(relative);
}

void AdaptiveFilm::assemble(Film& film) const {
  film.clear();
  const auto scale_of = [](const Half& half) { return 1.0 / half.used; };
  for (const Tile& tile : tiles_)
    for (int h = 0; h < 2; ++h) {
      const Half& half = tile.halves[h];
      if (half.used == 0) continue;
      const double scale = scale_of(half);
      for_each_pixel(tile.outer, [&](int x, int y) {
        const std::size_t from = index_in(tile.outer, x, y), pixel = film.pixel_index(x, y);
        const double* const sums = half.sums.data() + from * row_size();
        double* const row = film.sums_.data() + pixel * row_.film_size();
        for (std::size_t k = 0; k < squares_at(); ++k) row[k] += scale * sums[k];
        for (std::size_t bin = 0; bin < row_.bins; ++bin)
          row[row_.film_bins_at() + bin] += scale * sums[bins_at() + bin];
        if (!half.coverage.empty())
          for (const IdCoverage::Entry& entry : half.coverage[from].entries())
            film.coverage_[pixel].add(entry.shape, scale * entry.weight);
        if (h != 0 || film.half_.empty()) return;
        double* to = film.half_.data() + pixel * (1 + halved_.size());
        *to++ += scale * sums[0];
        for (const std::size_t c : halved_) *to++ += scale * sums[1 + c];
      });
      for_each_pixel(tile.own, [&](int x, int y) {
        film.counts_[film.pixel_index(x, y)] += half.counts[index_in(tile.own, x, y)];
      });
    }
  // With D_u = S_u - m W_u for a unit of n_u samples, m the pixel's mean: the variance of what a half of a tile brings
  // to the pixel is the scatter of D_u about its own mean n_u (sum of D_u) / n, as tiles see different parts of the
  // pixel.
  for (const Tile& tile : tiles_)
    for (const Half& half : tile.halves) {
      const double n = half.used, rest = 1 - half.used_squares / (n * n);
      if (half.used == 0 || !(rest > 1e-9)) continue;
      const double scale = scale_of(half);
      for_each_pixel(tile.outer, [&](int x, int y) {
        const double* const sums = half.sums.data() + index_in(tile.outer, x, y) * row_size();
        double* const row = film.sums_.data() + film.pixel_index(x, y) * row_.film_size();
        if (!(row[0] > 0)) return;
        const double* const squares = sums + squares_at();
        for (std::size_t k = 0; k < row_.variances; ++k) {
          const std::size_t c = 1 + row_.with_variance[k];
          const double m = row[c] / row[0], mean = (sums[c] - m * sums[0]) / n;
          const double* const of_channel = squares + 2 + 3 * k;
          const double square = of_channel[0] - 2 * m * of_channel[1] + m * m * squares[0];
          const double cross = of_channel[2] - m * squares[1];
          const double scatter = square - 2 * mean * cross + mean * mean * half.used_squares;
          // The film's formula with nothing but a sum of squares.
          row[row_.film_squares_at() + 1 + 2 * k] += scale * scale * std::max(0.0, scatter) / rest;
        }
      });
    }
}

RenderReport::Adaptive AdaptiveFilm::summary() const {
  RenderReport::Adaptive summary;
  summary.noise_target = goal_.noise;
  double pixels = 0, samples = 0;
  for (const Tile& tile : tiles_) {
    if (tile.own.area() == 0) continue;
    const std::uint32_t used = tile.halves[0].used + tile.halves[1].used;
    summary.least_samples = summary.tiles == 0 ? used : std::min(summary.least_samples, used);
    summary.most_samples = std::max(summary.most_samples, used);
    ++summary.tiles;
    summary.reached += tile.is_content() && tile.halves[0].samples < goal_.max_samples / 2 ? 1u : 0u;
    pixels += static_cast<double>(tile.own.area());
    samples += static_cast<double>(tile.own.area()) * used;
  }
  summary.mean_samples = pixels > 0 ? samples / pixels : 0.0;
  return summary;
}

}  // namespace sheaf

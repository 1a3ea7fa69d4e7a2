#include "kernels/film/adaptive_film.h"

#include "kernels/film/noise.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <map>

namespace sheaf {

namespace {

/// Minimum samples per pixel of a set before a tile may converge: fewer samples estimate noise too poorly.
constexpr std::uint32_t kMinSamples = 8;
constexpr std::uint32_t kFirstSamples = 2;
/// Sets double up to this size. Larger sets grow by at most half.
constexpr std::uint32_t kDoubledSamples = 16;

/// Number of samples that a set takes next. Sets have sizes 2^n or 1.5 * 2^n, because samplers stratify powers of two
/// best.
std::uint32_t next_samples(std::uint32_t taken) {
  if (taken < kMinSamples) return taken == 0 ? kFirstSamples : kMinSamples - taken;
  if (taken < kDoubledSamples) return taken;
  return std::bit_floor(taken / 2);
}

/// Number of samples of a set that needs `samples`.
double samples_of_set(double samples) {
  std::uint32_t size = 0;
  while (size < samples) size += next_samples(size);
  return size;
}

/// Radius of the window whose mean serves as the pixel's value, pixels.
constexpr int kValueReach = 2;

std::size_t index_in(const PixelRect& rect, int x, int y) {
  return static_cast<std::size_t>(y - rect.y0) * static_cast<std::size_t>(rect.width()) +
         static_cast<std::size_t>(x - rect.x0);
}

/// Calls f(x, y) for all pixels, row by row.
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
    for (Set& set : tile.sets) {
      set.sums.resize(tile.outer.area() * row_size());
      set.counts.resize(tile.own.area());
      if (film.has_surface_ids()) set.coverage.resize(tile.outer.area());
      set.luminance.resize(tile.judged().area() * 2);
    }
  }
}

bool AdaptiveFilm::begin_round() {
  const auto is_left = [](const AdaptiveUnit& unit) { return unit.done == 0; };
  if (std::any_of(units_.begin(), units_.end(), is_left)) return true;
  if (!units_.empty()) ++rounds_;
  units_.clear();
  const std::uint32_t max_per_half = goal_.max_samples / kSets;
  // The variance of one half's mean is twice the variance of the mean of both halves.
  const double requested = 2 * goal_.noise * goal_.noise;
  std::vector<double> needed[2];
  if (requested > 0)
    for (int half = 0; half < 2; ++half) needed[half] = needed_samples(tile_noise(half), requested, max_per_half);
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    Tile& tile = tiles_[i];
    const std::uint32_t taken = tile.sets[0].samples;
    if (tile.is_converged()) continue;
    // Test both halves, and estimate the final number of samples by the noisier one.
    const bool is_known = requested > 0 && taken >= kMinSamples;
    double expected = is_known ? taken : max_per_half;
    for (int half = 0; half < 2; ++half) {
      tile.converged[half] = tile.converged[half] || taken >= max_per_half || (is_known && needed[half][i] <= taken);
      if (is_known && !tile.converged[half]) expected = std::max(expected, needed[half][i]);
    }
    expected = std::min(samples_of_set(std::min(expected, 1.0 * max_per_half)), 1.0 * max_per_half);
    const std::uint32_t next = tile.is_converged() ? 0 : std::min(next_samples(taken), max_per_half - taken);
    expected_[i] = kSets * (tile.is_converged() ? taken : std::max(expected, 1.0 * (taken + next)));
    if (tile.is_converged()) continue;
    // Create the units of the tile.
    for (std::uint8_t set = 0; set < kSets; ++set)
      units_.push_back({static_cast<std::uint32_t>(i), taken, next, set, 0});
  }
  return !units_.empty();
}

bool AdaptiveFilm::has_estimates() const {
  // All unfinished tiles have equally many samples
  return goal_.noise == 0 || units_.empty() || units_.front().first_sample >= kMinSamples;
}

std::uint64_t AdaptiveFilm::taken_samples(std::size_t tile) const {
  std::uint64_t samples = 0;
  for (const Set& set : tiles_[tile].sets) samples += set.samples;
  return samples;
}

void AdaptiveFilm::add(std::size_t unit, const FilmTile& samples) {
  AdaptiveUnit& u = units_[unit];
  Tile& tile = tiles_[u.tile];
  Set& set = tile.sets[u.set];
  const int half = half_of(u.set);
  if (!tile.converged[1 - half]) {
    add_sums(tile, set, samples);
    set.used += u.samples;
  }
  if (!tile.converged[half]) add_luminance(tile, set, samples);
  set.samples += u.samples;
  u.done = 1;
}

void AdaptiveFilm::add_sums(const Tile& tile, Set& set, const FilmTile& samples) const {
  for_each_pixel(tile.outer, [&](int x, int y) {
    const double* const from = samples.row(x, y);
    const std::size_t pixel = index_in(tile.outer, x, y);
    double* const to = set.sums.data() + pixel * row_size();
    for (std::size_t k = 0; k < bins_at(); ++k) to[k] += from[k];
    for (std::size_t bin = 0; bin < row_.bins; ++bin) to[bins_at() + bin] += from[row_.bins_at + bin];
    if (!set.coverage.empty()) set.coverage[pixel].add(samples.coverage(x, y));
  });
  for_each_pixel(tile.own, [&](int x, int y) { set.counts[index_in(tile.own, x, y)] += samples.count(x, y); });
}

void AdaptiveFilm::add_luminance(const Tile& tile, Set& set, const FilmTile& samples) {
  double* to = set.luminance.data();
  for_each_pixel(tile.judged(), [&](int x, int y) {
    const double* const from = samples.row(x, y);
    *to++ += from[FilmRow::kWeight];
    *to++ += luminance_of(from + FilmRow::kSums);
  });
}

std::uint32_t AdaptiveFilm::judged_samples(const Tile& tile, int half) {
  // The luminance of a half grows as long as the image uses the samples of the other half.
  return tile.sets[2 * (1 - half)].used;
}

double AdaptiveFilm::mean_luminance(int half) const {
  double weight = 0, value = 0;
  for (const Tile& tile : tiles_)
    for (int s = 2 * half; s < 2 * half + 2; ++s) {
      const std::uint32_t samples = judged_samples(tile, half);
      const std::vector<double>& luminance = tile.sets[s].luminance;
      if (samples == 0) continue;
      for (std::size_t i = 0; i < luminance.size(); i += 2) {
        weight += luminance[i] / samples;
        value += luminance[i + 1] / samples;
      }
    }
  return weight > 0 ? value / weight : 0.0;
}

std::optional<double> AdaptiveFilm::noise_squared(const Tile& tile, int half, double mean_luminance) {
  const std::vector<double>&a = tile.sets[2 * half].luminance, &b = tile.sets[2 * half + 1].luminance;
  const PixelRect& pixels = tile.judged();
  double sum = 0, count = 0;
  for_each_pixel(pixels, [&](int x, int y) {
    const std::size_t i = 2 * index_in(pixels, x, y);
    if (!(a[i] > 0) || !(b[i] > 0)) return;
    // Use the mean over a window as the level. The pixel's own mean would hide a bright sample that only one set has
    // found; the minimum of both sets keeps pixels that are brighter than their neighborhood.
    double weight = 0, value = 0;
    const PixelRect around = PixelRect{x, y, x + 1, y + 1}.grown(kValueReach).intersection(pixels);
    for_each_pixel(around, [&](int u, int v) {
      const std::size_t k = 2 * index_in(pixels, u, v);
      weight += a[k] + b[k];
      value += a[k + 1] + b[k + 1];
    });
    const double first = a[i + 1] / a[i], second = b[i + 1] / b[i], apart = first - second;
    const double level = std::max(weight > 0 ? value / weight : 0.0, std::min(first, second));
    sum += relative_square(level, apart * apart / 4, mean_luminance);
    count += 1;
  });
  if (count == 0) return std::nullopt;
  return sum / count;
}

std::vector<TileNoise> AdaptiveFilm::tile_noise(int half) const {
  const double mean = mean_luminance(half);
  // Estimate the noise of each tile
  std::vector<TileNoise> tiles(tiles_.size());
  std::map<std::pair<int, int>, double> known;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const Tile& tile = tiles_[i];
    const auto samples = static_cast<double>(judged_samples(tile, half));
    tiles[i] = {static_cast<double>(tile.own.area()), 0, 0, samples, tile.converged[half]};
    const auto noise = noise_squared(tile, half, mean);
    if (noise) known[{tile.square.x0, tile.square.y0}] = tiles[i].variance = samples * *noise;
  }
  // Raise it to the mean of the neighborhood
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const PixelRect& square = tiles_[i].square;
    double sum = 0, count = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto at = known.find({square.x0 + dx * square.width(), square.y0 + dy * square.height()});
        if (at == known.end()) continue;
        sum += at->second;
        count += 1;
      }
    tiles[i].spread_variance = std::max(tiles[i].variance, count > 0 ? sum / count : 0.0);
  }
  return tiles;
}

void AdaptiveFilm::assemble(Film& film) const {
  film.clear();
  for (const Tile& tile : tiles_)
    for (int s = 0; s < kSets; ++s) {
      const Set& set = tile.sets[s];
      if (set.used == 0) continue;
      const double scale = 1.0 / set.used;
      // Add the sums of the set, ids and half buffer included
      for_each_pixel(tile.outer, [&](int x, int y) {
        const std::size_t from = index_in(tile.outer, x, y), pixel = film.pixel_index(x, y);
        const double* const sums = set.sums.data() + from * row_size();
        double* const row = film.sums_.data() + pixel * row_.film_size();
        for (std::size_t k = 0; k < bins_at(); ++k) row[k] += scale * sums[k];
        for (std::size_t bin = 0; bin < row_.bins; ++bin)
          row[row_.film_bins_at() + bin] += scale * sums[bins_at() + bin];
        if (!set.coverage.empty())
          for (const IdCoverage::Entry& entry : set.coverage[from].entries())
            film.coverage_[pixel].add(entry.shape, scale * entry.weight);
        if (half_of(s) != 0 || film.half_.empty()) return;
        double* to = film.half_.data() + pixel * (1 + halved_.size());
        *to++ += scale * sums[0];
        for (const std::size_t c : halved_) *to++ += scale * sums[1 + c];
      });
      // Count the samples
      for_each_pixel(tile.own, [&](int x, int y) {
        film.counts_[film.pixel_index(x, y)] += set.counts[index_in(tile.own, x, y)];
      });
    }
  for (const Tile& tile : tiles_) add_variances(tile, film);
}

/// Let m be a pixel's mean and D_s = (S_s - m W_s) / n_s for a set of n_s samples. The expectation of D_s is equal for
/// all sets of a tile, but it is not zero if the pixel also receives samples of other tiles. Therefore the sum of the
/// D_s has the variance k / (k - 1) * sum of (D_s - mean of D_s)^2 for k sets.
void AdaptiveFilm::add_variances(const Tile& tile, Film& film) const {
  double sets = 0;
  for (const Set& set : tile.sets) sets += set.used > 0 ? 1 : 0;
  if (sets < 2) {
    // With fewer than two sets the variance is unknown. Film::noise() recognizes the infinite weight square.
    for_each_pixel(tile.own, [&](int x, int y) {
      if (row_.variances == 0) return;
      film.sums_[film.pixel_index(x, y) * row_.film_size() + row_.film_squares_at()] =
          std::numeric_limits<double>::infinity();
    });
    return;
  }
  for_each_pixel(tile.outer, [&](int x, int y) {
    const std::size_t pixel = index_in(tile.outer, x, y);
    double* const row = film.sums_.data() + film.pixel_index(x, y) * row_.film_size();
    if (!(row[FilmRow::kWeight] > 0)) return;
    for (std::size_t k = 0; k < row_.variances; ++k) {
      const std::size_t c = FilmRow::kSums + row_.with_variance[k];
      const double m = row[c] / row[FilmRow::kWeight];
      double sum = 0, squares = 0;
      for (const Set& set : tile.sets) {
        if (set.used == 0) continue;
        const double* const sums = set.sums.data() + pixel * row_size();
        const double d = (sums[c] - m * sums[FilmRow::kWeight]) / set.used;
        sum += d;
        squares += d * d;
      }
      // Store the variance as the sum of squares, with zero sums of W_u^2 and S_u W_u; Film then computes it from that.
      row[row_.film_squares_at() + 1 + 2 * k] += std::max(0.0, squares - sum * sum / sets) * sets / (sets - 1);
    }
  });
}

AdaptiveSummary AdaptiveFilm::summary() const {
  AdaptiveSummary summary;
  summary.noise_target = goal_.noise;
  double pixels = 0, samples = 0;
  for (const Tile& tile : tiles_) {
    if (tile.own.area() == 0) continue;
    std::uint32_t used = 0;
    for (const Set& set : tile.sets) used += set.used;
    summary.min_samples = summary.tiles == 0 ? used : std::min(summary.min_samples, used);
    summary.max_samples = std::max(summary.max_samples, used);
    ++summary.tiles;
    summary.reached += tile.is_converged() && tile.sets[0].samples < goal_.max_samples / kSets ? 1u : 0u;
    pixels += static_cast<double>(tile.own.area());
    samples += static_cast<double>(tile.own.area()) * used;
  }
  summary.mean_samples = pixels > 0 ? samples / pixels : 0.0;
  return summary;
}

}  // namespace sheaf

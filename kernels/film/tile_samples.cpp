#include "kernels/film/tile_samples.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Upper bound on the samples of a tile over those of the best distribution. Tiles that took too few samples cannot
/// take more later, and the other tiles compensate for them within this bound.
constexpr double kMaxCompensation = 1.5;
constexpr int kBisections = 40;

}  // namespace

std::vector<double> needed_samples(std::span<const TileNoise> tiles, double requested, double max_samples) {
  const auto needed = [&](const TileNoise& tile, double scale) {
    const double by_tile = tile.spread_variance / (kMaxTileNoise * kMaxTileNoise * requested);
    return std::min(std::max(scale * std::sqrt(tile.spread_variance), by_tile), max_samples);
  };
  // Sum of the variances that remain if tiles take that many samples
  const auto remaining = [&](double scale) {
    double sum = 0;
    for (const TileNoise& tile : tiles) {
      const double samples = tile.is_final ? tile.samples : std::max(tile.samples, needed(tile, scale));
      if (samples > 0) sum += tile.pixels * tile.variance / samples;
    }
    return sum;
  };
  // The best distribution without regard to the samples that are taken already
  double pixels = 0, best = 0;
  for (const TileNoise& tile : tiles) {
    pixels += tile.pixels;
    if (tile.variance > 0) best += tile.pixels * tile.variance / std::sqrt(tile.spread_variance);
  }
  best /= std::max(requested * pixels, 1e-300);
  double low = 0, high = kMaxCompensation * best;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (remaining(middle) > requested * pixels ? low : high) = middle;
  }
  std::vector<double> samples;
  for (const TileNoise& tile : tiles) samples.push_back(needed(tile, high));
  return samples;
}

}  // namespace sheaf

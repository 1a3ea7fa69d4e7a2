// Number of samples that the tiles of adaptive sampling need for a noise target of the image.
#pragma once

#include <span>
#include <vector>

namespace sheaf {

/// Noise estimate of a tile. Variances are relative, of a pixel's single sample, and means over the tile's pixels.
struct TileNoise {
  double pixels = 0;           ///< whose noise counts
  double variance = 0;         ///< estimate from the tile's own samples
  double spread_variance = 0;  ///< the same, or that of the neighborhood if it is larger
  double samples = 0;          ///< per pixel, from which the variance was estimated
  bool is_final = false;       ///< the tile takes no more samples
};

/// Samples per pixel that each tile needs so that the mean relative variance of all pixels is `requested`, and that of
/// no tile is above kMaxTileNoise^2 times that. The cost is lowest if the number is proportional to the square root of
/// the variance (Neyman allocation); then tiles of equal noise save nothing over equal samples. No tile needs more than
/// `max_samples`.
std::vector<double> needed_samples(std::span<const TileNoise> tiles, double requested, double max_samples);

/// Maximum noise of a tile over that of the image.
inline constexpr double kMaxTileNoise = 2;

}  // namespace sheaf

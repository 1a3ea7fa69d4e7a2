// Layout of the row of sums that a film keeps for each pixel.
#pragma once

#include "kernels/film/film_layout.h"
#include "kernels/film/sample_buffer.h"

#include <vector>

namespace sheaf {

/// Offsets of the sums in a pixel's row, all in double precision. With w for a sample's weight in the pixel and v for a
/// channel's value, a row has three groups. The first holds the sums of w and of w v. The second holds the sums of w^2
/// and, for each channel with a variance, of (w v)^2 and of w (w v). The third holds the spectral bins. In tiles the
/// first and second group are padded to whole registers; in the film they are contiguous. Without variances there is no
/// second group, and tiles have none if the variances come from replicates.
struct FilmRow {
  static constexpr std::size_t kRegister = 8;  ///< maximum numbers in a register

  FilmRow() = default;
  FilmRow(const FilmLayout& layout, int spectral_bins, bool tiles_have_squares);

  std::size_t size() const { return bins_at + bins; }  ///< of a tile's row
  /// Numbers in the film's second group.
  std::size_t squares() const { return variances > 0 ? 1 + 2 * variances : 0; }
  /// Offsets in a row of the film.
  std::size_t film_squares_at() const { return kSums + channels; }
  std::size_t film_bins_at() const { return film_squares_at() + squares(); }
  std::size_t film_size() const { return film_bins_at() + bins; }

  std::size_t channels = 0, variances = 0, bins = 0;
  std::vector<std::size_t> with_variance;               ///< channels with a variance
  static constexpr std::size_t kWeight = 0, kSums = 1;  ///< offsets of the sum of weights and of the channels' sums
  /// Offset of the second group: this sum, then a pair for each channel with a variance.
  std::size_t weight_squared = 0;
  std::size_t tile_squares = 0;  ///< numbers in a tile's second group: squares() or 0
  std::size_t bins_at = 0;       ///< offset of the spectral bins
};

}  // namespace sheaf

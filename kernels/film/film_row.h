// What a film keeps of one pixel: a row of sums.
#pragma once

#include "kernels/film/film_layout.h"
#include "kernels/film/sample_buffer.h"

#include <vector>

namespace sheaf {

/// Where the sums stand in a pixel's row, each in double precision. With w a sample's weight in the pixel and v a
/// channel's value in it: sums of w and of w v; sums of squares, of w^2 and, for each channel with a variance, of
/// (w v)^2 and of w (w v); spectral bins. The first and the second group are padded to whole registers in tiles, and
/// stand side by side in the film. Without variances there is no second group, and where variances come from replicates
/// tiles have none.
struct FilmRow {
  static constexpr std::size_t kRegister = 8;  ///< numbers in a register, at most

  FilmRow() = default;
  FilmRow(const FilmLayout& layout, int spectral_bins, bool tiles_have_squares);

  std::size_t size() const { return bins_at + bins; }                            ///< of a tile's row
  std::size_t squares() const { return variances > 0 ? 1 + 2 * variances : 0; }  ///< numbers of the film's second group
  /// The same as below of a row of the film.
  std::size_t film_squares_at() const { return kSums + channels; }
  std::size_t film_bins_at() const { return film_squares_at() + squares(); }
  std::size_t film_size() const { return film_bins_at() + bins; }

  std::size_t channels = 0, variances = 0, bins = 0;
  std::vector<std::size_t> with_variance;               ///< channels that have one
  static constexpr std::size_t kWeight = 0, kSums = 1;  ///< the sum of weights; where the channels' sums begin
  std::size_t weight_squared = 0;  ///< where the second group begins; behind it pairs for each channel with a variance
  std::size_t tile_squares = 0;    ///< numbers of a tile's second group: squares() or none
  std::size_t bins_at = 0;         ///< where the bins begin
};

}  // namespace sheaf

#include "kernels/film/film_row.h"

namespace sheaf {

namespace {

constexpr std::size_t padded(std::size_t count) {
  return (count + FilmRow::kRegister - 1) / FilmRow::kRegister * FilmRow::kRegister;
}

}  // namespace

FilmRow::FilmRow(const FilmLayout& layout, int spectral_bins, bool tiles_have_squares)
    : channels(static_cast<std::size_t>(layout.size())),
      variances(static_cast<std::size_t>(layout.variance_count())),
      bins(static_cast<std::size_t>(spectral_bins)),
      weight_squared(padded(kSums + channels)),
      tile_squares(tiles_have_squares ? squares() : 0),
      bins_at(weight_squared + padded(tile_squares)) {
  for (std::size_t c = 0; c < channels; ++c)
    if (layout.channels()[c].has_variance) with_variance.push_back(c);
}

}  // namespace sheaf

// The film of a render that takes more samples where there is more noise. It cuts the frame into tiles, and the samples
// of each into two halves, A and B, that are independent of each other; round by round it says which tiles need more.
//
// A mean whose number of samples hangs on these samples is biased: it ends too early where the bright ones have not
// come yet. So the noise of A says how many samples of B are used, and that of B how many of A, each half counting as
// much as the other whatever its samples are (control by dual buffers goes back to Rousselle, Knaus and Zwicker,
// "Adaptive Rendering with Non-Local Means Filtering", SIGGRAPH Asia 2012). Where one half is content before the other
// both go on, and what the first does not need is left out.
#pragma once

#include "core/stats.h"
#include "kernels/film/film.h"

namespace sheaf {

/// When tiles have samples enough.
struct AdaptiveGoal {
  /// The standard error of a tile's pixels over their values, as of Film::noise(). 0: none, all tiles go on alike.
  double noise = 0;
  std::uint32_t max_samples = 2;  ///< per pixel, at least 2
};

/// Samples of a tile that are independent of all others.
struct AdaptiveUnit {
  std::uint32_t tile = 0;
  std::uint32_t samples = 0;  ///< per pixel
  std::uint32_t number = 0;   ///< among the tile's units, each once
  std::uint8_t half = 0;      ///< 0: A, 1: B
  std::uint8_t done = 0;
};

/// Sums of all tiles and halves.
class AdaptiveFilm {
 public:
  /// `film`: what is to become the picture, of the unit VarianceUnit::kReplicate. `tiles`: squares that hold all pixels
  /// of which samples are taken. `reach`: how many pixels away samples count.
  AdaptiveFilm(const Film& film, const std::vector<PixelRect>& tiles, int reach, AdaptiveGoal goal);

  /// Makes the next round's units, unless some of this round are left to do. Whether there are any.
  bool begin_round();
  const std::vector<AdaptiveUnit>& units() const { return units_; }
  /// Adds the samples of a unit, which is done then. Different units may be added by different threads at once.
  void add(std::size_t unit, const FilmTile& samples);
  /// Whether every tile has some samples in both halves.
  bool has_picture() const { return rounds_ > 0; }
  /// About how many samples per pixel tile `tile` will take in all, both halves together.
  double expected_samples(std::size_t tile) const { return expected_[tile]; }
  /// How many it has taken, the halves' together.
  std::uint64_t taken_samples(std::size_t tile) const {
    return std::uint64_t{tiles_[tile].halves[0].samples} + tiles_[tile].halves[1].samples;
  }

  /// Makes `film` the picture of what there is.
  void assemble(Film& film) const;
  RenderReport::Adaptive summary() const;

 private:
  friend void put_adaptive(BinaryOutput& out, const AdaptiveFilm& film);
  friend AdaptiveFilm get_adaptive(BinaryInput& in, const Film& of);

  struct Half {
    std::uint32_t samples = 0, used = 0;  ///< per pixel: taken, and used for the picture
    double used_squares = 0;            ///< sum of the squares of the units' samples per pixel, of those that are used
    bool content = false;               ///< the other half needs no more samples
    std::vector<double> sums;           ///< per pixel within reach a row, of what is used
    std::vector<std::uint64_t> counts;  ///< per pixel of the tile's own: samples that are used
    std::vector<IdCoverage> coverage;   ///< per pixel within reach, where surfaces are told
    std::vector<double> luminance;      ///< of each pixel whose noise counts, of all samples: see add_luminance()
  };
  struct Tile {
    PixelRect square;      ///< as given
    PixelRect own, outer;  ///< inside the film's crop: its own pixels, those within reach
    std::uint32_t units = 0;
    Half halves[2];

    bool is_content() const { return halves[0].content && halves[1].content; }
    /// The pixels whose noise counts: those within reach where the tile has none of its own.
    const PixelRect& judged() const { return own.area() > 0 ? own : outer; }
  };

  std::size_t row_size() const { return bins_at() + row_.bins; }
  std::size_t squares_at() const { return 1 + row_.channels; }
  std::size_t bins_at() const { return squares_at() + 2 + 3 * row_.variances; }
  void add_sums(const Tile& tile, Half& half, const AdaptiveUnit& unit, const FilmTile& samples) const;
  static void add_luminance(const Tile& tile, Half& half, const FilmTile& samples);
  double mean_luminance(int half) const;
  /// Mean square of the noise of the mean of a half's samples.
  static double noise_squared(const Half& half, double mean_luminance);

  FilmRow row_;
  std::vector<std::size_t> halved_;  ///< channels with FilmChannel::has_half
  AdaptiveGoal goal_;
  int reach_ = 0;
  std::vector<Tile> tiles_;
  std::vector<AdaptiveUnit> units_;
  std::uint32_t rounds_ = 0;  ///< that have ended
  std::vector<double> expected_;
};

}  // namespace sheaf

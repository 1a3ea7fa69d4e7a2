// The film of a render that takes more samples where there is more noise. It cuts the frame into tiles, and round by
// round says which of them need more. The samples of each are four sets that are independent of each other.
//
// A mean whose number of samples hangs on these samples is biased: it ends too early where the bright ones have not
// come yet. So two of the sets make half A, the other two half B; how far the sets of A lie apart says how many samples
// of B are used, and the other way round (two buffers that judge each other go back to Rousselle, Knaus and Zwicker,
// "Adaptive Rendering with Non-Local Means Filtering", SIGGRAPH Asia 2012). All sets count alike, whatever their
// samples are. Where one half is content before the other both go on, and what is not needed of them is left out.
#pragma once

#include "core/stats.h"
#include "kernels/film/film.h"

namespace sheaf {

/// When tiles have samples enough.
struct AdaptiveGoal {
  /// The standard error of a tile's pixels over their values, about as of Film::noise(). 0: none, all go on alike.
  double noise = 0;
  std::uint32_t max_samples = 4;  ///< per pixel, at least kSets
};

/// The next samples of a set.
struct AdaptiveUnit {
  std::uint32_t tile = 0;
  std::uint32_t first_sample = 0, samples = 0;  ///< of each pixel, counted in the set
  std::uint8_t set = 0;                         ///< 0 and 1: of half A; 2 and 3: of half B
  std::uint8_t done = 0;
};

/// Sums of all tiles and sets.
class AdaptiveFilm {
 public:
  static constexpr std::uint8_t kSets = 4;

  /// `film`: what is to become the picture, of the unit VarianceUnit::kReplicate. `tiles`: squares that hold all pixels
  /// of which samples are taken. `reach`: how many pixels away samples count.
  AdaptiveFilm(const Film& film, const std::vector<PixelRect>& tiles, int reach, AdaptiveGoal goal);

  /// Makes the next round's units, unless some of this round are left to do. Whether there are any.
  bool begin_round();
  const std::vector<AdaptiveUnit>& units() const { return units_; }
  /// Adds the samples of a unit, which is done then. Different units may be added by different threads at once.
  void add(std::size_t unit, const FilmTile& samples);
  /// Whether every tile has some samples in all sets.
  bool has_picture() const { return rounds_ > 0; }
  /// About how many samples per pixel a tile will take, all sets together.
  double expected_samples(std::size_t tile) const { return expected_[tile]; }
  /// How many it has taken.
  std::uint64_t taken_samples(std::size_t tile) const;

  /// Makes `film` the picture of what there is.
  void assemble(Film& film) const;
  RenderReport::Adaptive summary() const;

 private:
  friend void put_adaptive(BinaryOutput& out, const AdaptiveFilm& film);
  friend AdaptiveFilm get_adaptive(BinaryInput& in, const Film& of);

  struct Set {
    std::uint32_t samples = 0, used = 0;  ///< per pixel: taken, and used for the picture
    std::vector<double> sums;             ///< per pixel within reach a row, of what is used
    std::vector<std::uint64_t> counts;    ///< per pixel of the tile's own: samples that are used
    std::vector<IdCoverage> coverage;     ///< per pixel within reach, where surfaces are told
    /// Of each pixel whose noise counts, of all samples: the sums of weights and of luminance.
    std::vector<double> luminance;
  };
  struct Tile {
    PixelRect square;      ///< as given
    PixelRect own, outer;  ///< inside the film's crop: its own pixels, those within reach
    Set sets[kSets];
    bool content[2] = {};  ///< by half: the other one needs no more samples

    bool is_content() const { return content[0] && content[1]; }
    /// The pixels whose noise counts: those within reach where the tile has none of its own.
    const PixelRect& judged() const { return own.area() > 0 ? own : outer; }
  };

  static int half_of(int set) { return set / 2; }
  std::size_t bins_at() const { return 1 + row_.channels; }
  std::size_t row_size() const { return bins_at() + row_.bins; }
  void add_sums(const Tile& tile, Set& set, const FilmTile& samples) const;
  static void add_luminance(const Tile& tile, Set& set, const FilmTile& samples);
  void add_variances(const Tile& tile, Film& film) const;
  double mean_luminance(int half) const;
  /// Mean square of the noise of the mean of a half's samples in a tile; nothing where it has none.
  static std::optional<double> noise_squared(const Tile& tile, int half, double mean_luminance);
  /// Those of all tiles, each no less than the mean of it and its neighbours: few samples hardly tell rare bright ones.
  std::vector<double> spread_noise(int half) const;

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

// Film for adaptive sampling. It divides the frame into tiles and decides in rounds which tiles need more samples for
// the noise target of the image (kernels/film/tile_samples.h). Each tile has four independent sets of samples.
//
// If the number of samples depends on the samples themselves, the mean is biased: a pixel stops too early while it has
// missed its rare bright samples. Therefore two of the sets form half A and the other two half B. The difference
// between the sets of A decides how many samples of B the image uses, and vice versa. Such cross-validated buffers go
// back to Rousselle, Knaus and Zwicker, "Adaptive Rendering with Non-Local Means Filtering", SIGGRAPH Asia 2012. All
// sets have equal weight, whatever their samples are. If one half converges before the other, both continue; the
// samples that the image does not need are discarded.
#pragma once

#include "kernels/film/film.h"
#include "kernels/film/tile_samples.h"

#include <optional>

namespace sheaf {

/// Stopping criterion.
struct AdaptiveGoal {
  /// Target for the relative standard error of the image's pixels, approximately as in Film::noise(). 0 disables the
  /// target: all tiles take max_samples.
  double noise = 0;
  std::uint32_t max_samples = 4;  ///< per pixel, at least kSets
};

/// A work item: the next samples of one set of one tile.
struct AdaptiveUnit {
  std::uint32_t tile = 0;
  std::uint32_t first_sample = 0, samples = 0;  ///< of each pixel; index within the set
  std::uint8_t set = 0;                         ///< 0 and 1 belong to half A, 2 and 3 to half B
  std::uint8_t done = 0;
};

/// The number of samples that adaptive sampling has taken.
struct AdaptiveSummary {
  double noise_target = 0;  ///< target noise of the image; 0: none
  double mean_samples = 0;  ///< per pixel, of the samples that are used
  std::uint32_t min_samples = 0, max_samples = 0;
  std::uint64_t tiles = 0, reached = 0;  ///< tiles of the image, and those with enough samples
};

/// Sample sums of all tiles and sets.
class AdaptiveFilm {
 public:
  static constexpr std::uint8_t kSets = 4;

  /// `film`: the film that assemble() fills later; its variance unit is VarianceUnit::kReplicate. `tiles`: squares that
  /// cover all sampled pixels. `reach`: radius of the pixel filter's support, pixels.
  AdaptiveFilm(const Film& film, const std::vector<PixelRect>& tiles, int reach, AdaptiveGoal goal);

  /// Starts the next round and creates its units, unless units of the current round are unfinished. Returns whether
  /// there are units to render.
  bool begin_round();
  const std::vector<AdaptiveUnit>& units() const { return units_; }
  /// Adds the samples of a unit and marks it as done. Different threads may add different units concurrently.
  void add(std::size_t unit, const FilmTile& samples);
  /// Whether every set of every tile has samples.
  bool has_image() const { return rounds_ > 0; }
  /// Estimated final number of samples per pixel of a tile, summed over all sets.
  double expected_samples(std::size_t tile) const { return expected_[tile]; }
  /// Whether expected_samples() is an estimate rather than an upper bound: the noise is known, or there is no noise
  /// target.
  bool has_estimates() const;
  /// Number of samples per pixel that a tile has taken so far, summed over all sets.
  std::uint64_t taken_samples(std::size_t tile) const;

  /// Writes the image of the samples so far into `film`.
  void assemble(Film& film) const;
  AdaptiveSummary summary() const;

 private:
  friend void put_adaptive(BinaryOutput& out, const AdaptiveFilm& film);
  friend AdaptiveFilm get_adaptive(BinaryInput& in, const Film& of);

  struct Set {
    std::uint32_t samples = 0, used = 0;  ///< per pixel: taken, and used for the image
    std::vector<double> sums;             ///< one row per pixel within reach, of the used samples
    std::vector<std::uint64_t> counts;    ///< used samples of each of the tile's own pixels
    std::vector<IdCoverage> coverage;     ///< per pixel within reach; only with surface ids
    /// For each pixel of judged(): the sum of weights and the sum of luminance. Grows until the set's half has
    /// converged.
    std::vector<double> luminance;
  };
  struct Tile {
    PixelRect square;      ///< as passed to the constructor
    PixelRect own, outer;  ///< clipped to the crop window: own pixels; pixels within reach
    Set sets[kSets];
    bool converged[2] = {};  ///< [h]: half h has converged, so the image needs no more samples of the other half

    bool is_converged() const { return converged[0] && converged[1]; }
    /// Pixels whose variance is tested: the tile's, or those within reach if the tile has none inside the crop window.
    const PixelRect& judged() const { return own.area() > 0 ? own : outer; }
  };

  static int half_of(int set) { return set / 2; }
  std::size_t bins_at() const { return 1 + row_.channels; }
  std::size_t row_size() const { return bins_at() + row_.bins; }
  void add_sums(const Tile& tile, Set& set, const FilmTile& samples) const;
  static void add_luminance(const Tile& tile, Set& set, const FilmTile& samples);
  void add_variances(const Tile& tile, Film& film) const;
  /// Samples per pixel of each set of a half from which the noise of a tile is estimated.
  static std::uint32_t judged_samples(const Tile& tile, int half);
  double mean_luminance(int half) const;
  /// Relative variance of the mean of one half, estimated from its two sets: the mean over a tile's pixels. It includes
  /// the worst pixels: most tiles have found only a few of the rare bright samples that dominate their noise. Returns
  /// nothing if no pixel has samples in both sets.
  static std::optional<double> noise_squared(const Tile& tile, int half, double mean_luminance);
  /// noise_squared() of all tiles. The spread variance is at least the mean over the tile and its eight neighbors,
  /// because few samples often miss rare bright ones.
  std::vector<TileNoise> tile_noise(int half) const;

  FilmRow row_;
  std::vector<std::size_t> halved_;  ///< channels with FilmChannel::has_half
  AdaptiveGoal goal_;
  int reach_ = 0;
  std::vector<Tile> tiles_;
  std::vector<AdaptiveUnit> units_;
  std::uint32_t rounds_ = 0;  ///< finished rounds
  std::vector<double> expected_;
};

}  // namespace sheaf

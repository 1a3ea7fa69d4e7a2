// The film: weighted sums of samples per pixel, from which the image and its variance are computed (PBR 5.4).
#pragma once

#include "core/image/image.h"
#include "kernels/film/film_tile.h"

#include <optional>
#include <span>

namespace sheaf {

class BinaryInput;
class BinaryOutput;

/// Maximum number of spectral bins: one per nm from 360 to 830.
inline constexpr int kMaxSpectralBins = 471;

/// The unit whose scatter estimates the variance of a pixel.
enum class VarianceUnit : std::uint8_t {
  kSample,     ///< samples; correct if they are independent of each other
  kReplicate,  ///< replicates: consecutive, independent sets of samples
};

/// Pixel sums in double precision. A pixel's value is the weighted mean of its samples, sum of w v / sum of w. If
/// samples contribute only to their own pixel, w is 1.
///
/// Let u be a unit, that is a sample or a replicate, W_u its sum of w, S_u its sum of w v, and m = sum of S_u / sum of
/// W_u. To first order in 1 / n, the variance of m is the sum of (S_u - m W_u)^2 over the square of the sum of W_u.
/// See Cochran, "Sampling Techniques" (1977), chapter 6. Division by 1 - (sum of W_u^2) / (sum of W_u)^2 makes it
/// unbiased if all W_u are equal.
///
/// Each finished tile is added at once, every pixel by the one tile that owns it. Borders are added when all tiles of a
/// pass have finished, in the order of tiles. Therefore a pixel's bits depend only on how the frame is divided into
/// tiles and passes.
class Film {
 public:
  Film() = default;
  /// `crop` must lie inside the frame. `spectral_bins`: number of bins of equal width from 360 to 830 nm, at most
  /// kMaxSpectralBins. `has_surface_ids`: samples have SurfaceSamples.
  Film(int frame_width, int frame_height, PixelRect crop, FilmLayout layout = FilmLayout::beauty(),
       int spectral_bins = 0, VarianceUnit unit = VarianceUnit::kSample, bool has_surface_ids = false);

  int width() const { return frame_width_; }
  int height() const { return frame_height_; }
  const PixelRect& crop() const { return crop_; }
  const FilmLayout& layout() const { return layout_; }
  /// Numbers per pixel of a tile's row.
  std::size_t tile_row_size() const { return row_.size(); }
  int spectral_bins() const { return static_cast<int>(row_.bins); }
  VarianceUnit variance_unit() const { return unit_; }

  /// Begins a tile of this film; see FilmTile::begin().
  void begin(FilmTile& tile, const PixelRect& own, const FilterWeights* weights) const {
    tile.begin(row_, weights, own, crop_, has_surface_ids());
  }
  /// Adds the tile's own pixels. Different threads may add different tiles concurrently.
  void add(const FilmTile& tile);
  /// Adds the contributions of tiles to the pixels of other tiles, in the given order. Multithreaded.
  void add(std::span<const FilmBorder> borders);
  /// Ends a replicate, which consists of everything added since the previous one ended. Does nothing if samples are the
  /// units.
  void end_replicate();

  /// Removes all samples.
  void clear();

  /// Marks the end of the first half of the samples, whose means become layers of the image.
  void end_first_half();

  /// Number of samples taken in pixel (x, y) of the frame, without dropped ones. The pixel must lie inside the crop.
  std::uint64_t count(int x, int y) const { return counts_[pixel_index(x, y)]; }
  /// Mean of count() over the crop window.
  double mean_samples() const;

  bool has_surface_ids() const { return !coverage_.empty(); }
  /// Sums of sample weights by surface. Requires has_surface_ids().
  const IdCoverage& coverage(int x, int y) const { return coverage_[pixel_index(x, y)]; }

  /// The image of the crop window, without the layers of AovSource::kSurfaceId. Its channels are, in this order:
  ///   - the mean of each channel
  ///   - the variances of these means: zero with fewer than two units, and for replicates that have not ended
  ///   - sampleCount
  ///   - the mean spectral radiance of each bin, if the film has bins. The channel names follow Fichet, Pacanowski and
  ///     Wilkie, "An OpenEXR Layout for Spectral Images" (2021): the bin around 550 nm is "S0.550,000000nm".
  ///   - the means of the first half of the samples, zero until end_first_half()
  ///
  /// Pixels without samples are zero.
  Image to_image() const;

  /// The channels R, G, B and A, if the film has them, of to_image(). Much faster for films with more channels.
  Image beauty_image() const;

  /// Appends the layers that merging needs (see merge.h) to this film's image, which holds part of the samples:
  ///   - "part.weight", the sum W of weights
  ///   - with variances: "part.weightSquared", Q = sum of W_u^2
  ///   - with variances, and m for the channel's mean as stored: "part.scatter." + channel, the sum of
  ///     (S_u - m W_u)^2, and "part.cross." + channel, the sum of (S_u - m W_u) W_u
  ///   - with a first half: "part.halfWeight", its sum of weights
  ///
  /// The function also writes means if the sum of weights is negative, which the negative lobes of a filter can cause
  /// with few samples.
  void add_part_layers(Image& image) const;

  /// Relative noise of the image: the standard error of a pixel's luminance over its value, as the root mean square
  /// over all pixels without the worst 0.1%. Dark pixels count as if they had a tenth of the image's mean. Returns
  /// nothing if R, G and B have no variances. Also returns nothing if more than 0.1% of the pixels have fewer than two
  /// units, as in a render that was interrupted early.
  std::optional<double> noise() const;

 private:
  friend void put_film(BinaryOutput& out, const Film& film);
  friend Film get_film(BinaryInput& in);
  friend class AdaptiveFilm;

  std::size_t pixel_index(int x, int y) const {
    return static_cast<std::size_t>(y - crop_.y0) * static_cast<std::size_t>(crop_.width()) +
           static_cast<std::size_t>(x - crop_.x0);
  }
  void add(int x, int y, const double* sums);
  void write_pixel(std::size_t pixel, float* out) const;
  /// An image of the crop window whose pixels are zero.
  Image empty_image(std::vector<std::string> channels) const;

  int frame_width_ = 0, frame_height_ = 0;
  PixelRect crop_;
  FilmLayout layout_;
  VarianceUnit unit_ = VarianceUnit::kSample;
  FilmRow row_;
  std::vector<std::uint64_t> counts_;  ///< per pixel
  std::vector<double> sums_;           ///< one row per pixel; the second group covers only the units that have ended
  /// Current replicate, per pixel: the sum of weights and the sum of each channel with a variance.
  std::vector<double> open_;
  /// First half, per pixel: the sum of weights and the sum of each channel with FilmChannel::has_half.
  std::vector<double> half_;
  std::vector<IdCoverage> coverage_;  ///< per pixel; only with surface ids
};

}  // namespace sheaf

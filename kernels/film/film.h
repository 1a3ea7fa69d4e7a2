// The film: sums of samples per pixel, from which the picture and its variance are made.
#pragma once

#include "core/image.h"
#include "kernels/film/film_tile.h"

#include <optional>
#include <span>

namespace sheaf {

class BinaryInput;
class BinaryOutput;

/// Most bins: one for every nm from 360 to 830.
inline constexpr int kMaxSpectralBins = 471;

/// What the variance of a pixel is estimated from.
enum class VarianceUnit : std::uint8_t {
  kSample,     ///< the scatter of samples: right where these are independent of each other
  kReplicate,  ///< that of replicates: sets of samples that are independent of each other, one after the other
};

/// Pixel sums in double precision. A pixel's value is the mean of its samples by weight, sum of w v / sum of w; where
/// samples count in their own pixel alone w is 1.
///
/// With u for a unit, a sample or a replicate, W_u its sum of w, S_u its sum of w v, and m = sum of S_u / sum of W_u,
/// the variance of m is, to the first order in 1 / n, the sum of (S_u - m W_u)^2 over the square of the sum of W_u
/// (Cochran, "Sampling Techniques", 1977, chapter 6); divided by 1 - (sum of W_u^2) / (sum of
/// W_u)^2, which makes it unbiased where all W_u are the same.
///
/// Tiles are added as they end, each pixel by the one tile that owns it; borders when all tiles of a pass have ended,
/// in the order of tiles. So a pixel's bits depend on how the frame is cut into tiles and passes alone.
class Film {
 public:
  Film() = default;
  /// `crop` must lie inside the frame. `spectral_bins`: of equal width from 360 to 830 nm, at most kMaxSpectralBins.
  /// `has_surface_ids`: whether samples have SurfaceSamples.
  Film(int frame_width, int frame_height, PixelRect crop, FilmLayout layout = FilmLayout::beauty(),
       int spectral_bins = 0, VarianceUnit unit = VarianceUnit::kSample, bool has_surface_ids = false);

  int width() const { return frame_width_; }
  int height() const { return frame_height_; }
  const PixelRect& crop() const { return crop_; }
  const FilmLayout& layout() const { return layout_; }
  /// Numbers per pixel of a tile.
  std::size_t tile_row_size() const { return row_.size(); }
  int spectral_bins() const { return static_cast<int>(row_.bins); }
  VarianceUnit variance_unit() const { return unit_; }

  /// Begins a tile of this film; see FilmTile::begin().
  void begin(FilmTile& tile, const PixelRect& own, const FilterWeights* weights) const {
    tile.begin(row_, weights, own, crop_, has_surface_ids());
  }
  /// Adds the tile's own pixels. Different tiles may be added by different threads at once.
  void add(const FilmTile& tile);
  /// Adds what tiles bring to the pixels of others, in the order given. Uses threads.
  void add(std::span<const FilmBorder> borders);
  /// Ends a replicate: what was added since the last one, or since the beginning. Nothing where samples are the units.
  void end_replicate();

  /// Takes all samples out again.
  void clear();

  /// Ends the first half of the samples, whose means the picture is to have besides.
  void end_first_half();

  /// How many samples were taken in the pixel (x, y) of the frame, inside the crop, and not dropped.
  std::uint64_t count(int x, int y) const { return counts_[pixel_index(x, y)]; }
  /// The mean of count() over the crop.
  double mean_samples() const;

  bool has_surface_ids() const { return !coverage_.empty(); }
  /// What the weights of samples on surfaces add up to. Only where they are told.
  const IdCoverage& coverage(int x, int y) const { return coverage_[pixel_index(x, y)]; }

  /// The picture over the crop, without the layers of AovSource::kSurfaceId: the mean of each channel, the variances of
  /// these means (zero below two units, and in replicates that have not ended), sampleCount, and the means of the first
  /// half of the samples (zero before that has ended). Pixels without samples are zero. A film with bins has the mean
  /// spectral radiance over each of them besides, in channels as of Fichet, Pacanowski and Wilkie, "An OpenEXR Layout
  /// for Spectral Images" (2021): the name of the bin around 550 nm is "S0.550,000000nm".
  Image to_image() const;

  /// Appends to this picture, of some of the samples, what joining it with those of the others needs (see merge.h): the
  /// layers "part.weight", the sum W of weights; with variances "part.weightSquared", Q = sum of W_u^2, and with m for
  /// the channel's mean as it is stored "part.scatter." + channel, sum of (S_u - m W_u)^2, and "part.cross." + channel,
  /// sum of (S_u - m W_u) W_u; with a first half "part.halfWeight", its sum of weights. Here means are those of weights
  /// below zero too, which negative lobes of a filter may leave where samples are few.
  void add_part_layers(Image& image) const;

  /// How noisy the picture is: the standard error of a pixel's luminance over its value, root of the mean square over
  /// the pixels without the worst thousandth. Dark pixels count as if they had a tenth of the picture's mean. Nothing
  /// where R, G and B have no variances, and where more than a thousandth of the pixels have fewer than two units to
  /// estimate them from, as in a render that was interrupted early.
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

  int frame_width_ = 0, frame_height_ = 0;
  PixelRect crop_;
  FilmLayout layout_;
  VarianceUnit unit_ = VarianceUnit::kSample;
  FilmRow row_;
  std::vector<std::uint64_t> counts_;  ///< per pixel
  std::vector<double> sums_;           ///< per pixel a row; its second group is of the units that have ended
  /// Of the replicate that has not ended, per pixel: the sum of weights and, for each channel with a variance, its sum.
  std::vector<double> open_;
  /// Of the first half, per pixel: the sum of weights and, for each channel with FilmChannel::has_half, its sum.
  std::vector<double> half_;
  std::vector<IdCoverage> coverage_;  ///< per pixel, where surfaces are told
};

}  // namespace sheaf

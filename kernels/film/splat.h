// Light that photons send to the camera, wherever on the film it lands; and the picture that it adds up to.
#pragma once

#include "core/image.h"
#include "core/pixel_rect.h"
#include "scene/tables/filter.h"

#include <array>
#include <span>
#include <vector>

namespace sheaf {

class BinaryInput;
class BinaryOutput;

/// What one vertex of a photon sends to the camera.
struct Splat {
  float x = 0, y = 0;       ///< film position, pixels from the frame's upper left corner
  float rgb[3] = {};        ///< linear Rec.709; over the number of all photons, its share of radiance times film area
  std::uint64_t order = 0;  ///< photon of the task, and vertex of the photon
};

/// What a splat counts in the pixels around it: what camera samples would count there on average, so that pictures of
/// both kinds have the same mean, also at the frame's edge.
///
/// FilterMode::kWeighted: camera samples lie on the sampled pixels alone, and a pixel is their mean by weight. So a
/// splat beyond the sampled pixels counts nothing, and its weight elsewhere is the filter's value over the integral of
/// the part of the filter that the sampled pixels hold. FilterMode::kImportance: over the whole integral, and splats
/// count from wherever the filter reaches.
class SplatFilter {
 public:
  /// `sampled`: the pixels that camera samples are taken of, the frame and its border, whatever the crop. `turn`: of
  /// cameras that see a whole turn, its width in pixels: what is so far apart is the same; else 0. Throws SceneError
  /// for a filter that make_filter_table() refuses.
  SplatFilter(const FilterDescription& filter, FilterMode mode, const PixelRect& sampled, float turn = 0);

  float turn() const { return turn_; }
  /// How many turns away a film position may still count.
  int turns() const { return turn_ > 0 ? 1 + static_cast<int>(static_cast<float>(weights_.reach()) / turn_) : 0; }

  /// A film position counts if it lies inside of these bounds, of which the crop is within reach.
  struct Bounds {
    float x0, y0, x1, y1;
  };
  Bounds bounds(const PixelRect& crop) const;

  /// The pixels along one axis in which a splat counts, of those in [begin, end).
  struct Span {
    int first = 0, count = 0;
    int skipped = 0;  ///< how many pixels within reach come before the first
    /// Of all pixels within reach. Not initialised: only those of the filter's length are used.
    std::array<double, FilterWeights::kMaxPixels> weights;

    double weight(int i) const { return weights[static_cast<std::size_t>(skipped + i)]; }
  };
  Span across(float x, int begin, int end) const { return span(x, begin, end, sampled_.x0, sampled_.x1); }
  Span down(float y, int begin, int end) const { return span(y, begin, end, sampled_.y0, sampled_.y1); }

 private:
  Span span(float at, int begin, int end, int sampled_begin, int sampled_end) const;
  /// The filter's integral over the sampled pixels, around the pixel `at` of one axis.
  double integral(int at, int sampled_begin, int sampled_end) const;

  FilterWeights weights_;
  PixelRect sampled_;
  bool is_weighted_;
  float turn_;
  /// Element i: the filter's integral over the first i pixels within reach.
  std::vector<double> cumulative_;
};

/// An image made of splats: each counts in all pixels under the reconstruction filter, in double precision.
class SplatFilm {
 public:
  SplatFilm() = default;
  /// `crop` must lie inside the frame.
  explicit SplatFilm(PixelRect crop);

  /// Adds the splats of tasks, in their order. Uses threads; the sums' bits don't depend on how many.
  void add(std::span<const std::vector<Splat>> tasks, const SplatFilter& filter);

  /// Adds the mean over `photons` photons to the channels R, G and B of a picture of the crop, and its variance, as if
  /// all splats were independent of each other, to those of their variances.
  void add_to(Image& image, std::uint64_t photons) const;

 private:
  friend void put_splats(BinaryOutput& out, const SplatFilm& film);
  friend void get_splats(BinaryInput& in, SplatFilm& film);

  PixelRect crop_;
  std::vector<double> sums_, squares_;  ///< per pixel, three each
};

}  // namespace sheaf

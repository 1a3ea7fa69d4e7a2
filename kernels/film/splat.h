// Splats: contributions of light tracing to arbitrary film positions, and the image that accumulates them (PBR 5.4).
#pragma once

#include "core/image/image.h"
#include "core/image/pixel_rect.h"
#include "scene/tables/filter.h"

#include <array>
#include <span>
#include <vector>

namespace sheaf {

class BinaryInput;
class BinaryOutput;

/// Contribution of one photon vertex to the camera.
struct Splat {
  float x = 0, y = 0;       ///< film position, pixels from the upper left corner of the frame
  float rgb[3] = {};        ///< linear Rec.709; divided by the number of photons: radiance times film area
  std::uint64_t order = 0;  ///< photon of the task in the upper bits, vertex of the photon in the lower 16
};

/// Weights of a splat in the pixels around it. They equal the average weights of camera samples. Therefore images
/// of camera paths and of light tracing have the same expectation, even at the edge of the frame.
///
/// FilterMode::kWeighted: camera samples lie only on the sampled pixels, and a pixel is their weighted mean. A splat
/// outside the sampled pixels has no effect. Elsewhere its weight is the filter's value over the integral of the filter
/// across the sampled pixels. FilterMode::kImportance: the weight is the filter's value over its whole integral, and
/// splats count from every position within the filter's support.
class SplatFilter {
 public:
  /// `sampled`: the pixels of camera samples, that is the frame and its border, regardless of the crop window.
  /// `panorama_width`: width of 360 degrees in pixels for panoramic cameras, where positions this far apart are equal;
  /// otherwise 0. Throws SceneError for a filter that make_filter_table() rejects.
  SplatFilter(const PixelFilter& filter, FilterMode mode, const PixelRect& sampled, float panorama_width = 0);

  float panorama_width() const { return panorama_width_; }
  /// Maximum number of panorama widths between a film position and the pixels that it can reach.
  int wraps() const {
    return panorama_width_ > 0 ? 1 + static_cast<int>(static_cast<float>(weights_.reach()) / panorama_width_) : 0;
  }

  /// Film positions that can reach the crop window.
  struct Bounds {
    float x0, y0, x1, y1;
  };
  Bounds bounds(const PixelRect& crop) const;

  /// The pixels in [begin, end) along one axis that a splat reaches.
  struct Span {
    int first = 0, count = 0;
    int skipped = 0;  ///< pixels within reach before the first one
    /// Weights of all pixels within reach. Not initialized: only the first length() of the filter are used.
    std::array<double, FilterWeights::kMaxPixels> weights;

    double weight(int i) const { return weights[static_cast<std::size_t>(skipped + i)]; }
  };
  Span across(float x, int begin, int end) const { return span(x, begin, end, sampled_.x0, sampled_.x1); }
  Span down(float y, int begin, int end) const { return span(y, begin, end, sampled_.y0, sampled_.y1); }

 private:
  Span span(float at, int begin, int end, int sampled_begin, int sampled_end) const;
  /// Integral of the filter over the sampled pixels along one axis, centered on pixel `at`.
  double integral(int at, int sampled_begin, int sampled_end) const;

  FilterWeights weights_;
  PixelRect sampled_;
  bool is_weighted_;
  float panorama_width_;
  /// Element i is the integral of the filter over the first i pixels within reach.
  std::vector<double> cumulative_;
};

/// Image of splats in double precision. Each splat contributes to all pixels under the pixel filter.
class SplatFilm {
 public:
  SplatFilm() = default;
  /// `crop` must lie inside the frame.
  explicit SplatFilm(PixelRect crop);

  /// Adds the splats of tasks in their order. Multithreaded; the bits do not depend on the number of threads.
  void add(std::span<const std::vector<Splat>> tasks, const SplatFilter& filter);

  /// Adds the mean over `photons` photons to the channels R, G and B of an image of the crop window. Adds its variance
  /// to their variance channels, as if all splats were independent.
  void add_to(Image& image, std::uint64_t photons) const;

 private:
  friend void put_splats(BinaryOutput& out, const SplatFilm& film);
  friend void get_splats(BinaryInput& in, SplatFilm& film);

  PixelRect crop_;
  std::vector<double> sums_, squares_;  ///< per pixel, three each
};

}  // namespace sheaf

// The film: sums of samples per pixel, from which the picture and its variance are made.
#pragma once

#include "core/image.h"
#include "scene/description.h"

#include <array>

namespace sheaf {

/// A finished camera sample: radiance (linear Rec.709) and coverage, premultiplied.
struct FilmSample {
  float r = 0, g = 0, b = 0, alpha = 0;
};

/// Pixel sums in double precision. Samples of one pixel must be added in the order of their sample index; different
/// pixels may be added to by different threads at once.
class Film {
 public:
  Film() = default;
  /// `crop` must lie inside the frame.
  Film(int frame_width, int frame_height, PixelRect crop);

  int width() const { return frame_width_; }
  int height() const { return frame_height_; }
  const PixelRect& crop() const { return crop_; }

  /// Adds a sample to the pixel (x, y) of the frame, which must lie inside the crop.
  void add(int x, int y, const FilmSample& sample) {
    Pixel& p = pixels_[static_cast<std::size_t>(y - crop_.y0) * static_cast<std::size_t>(crop_.width()) +
                       static_cast<std::size_t>(x - crop_.x0)];
    const double v[3] = {sample.r, sample.g, sample.b};
    for (int c = 0; c < 3; ++c) {
      p.sum[c] += v[c];
      p.sum_of_squares[c] += v[c] * v[c];
    }
    p.alpha += sample.alpha;
    ++p.count;
  }

  /// The picture: R, G, B, A (means), variance.R/G/B (of the mean, as if samples
  /// were independent; zero below two samples) and sampleCount, over the
  /// crop. Pixels without samples are zero.
  Image to_image() const;

 private:
  struct Pixel {
    std::array<double, 3> sum{}, sum_of_squares{};
    double alpha = 0;
    std::uint64_t count = 0;
  };

  int frame_width_ = 0, frame_height_ = 0;
  PixelRect crop_;
  std::vector<Pixel> pixels_;
};

}  // namespace sheaf

// Light that photons send to the camera, wherever on the film it lands; and the picture that it adds up to.
#pragma once

#include "core/image.h"
#include "core/pixel_rect.h"
#include "scene/tables/filter.h"

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

/// A picture made of splats: each counts in all pixels under the reconstruction filter, in double precision.
class SplatFilm {
 public:
  SplatFilm() = default;
  /// `crop` must lie inside the frame. Throws SceneError for a filter that make_filter_table() refuses.
  SplatFilm(PixelRect crop, const FilterDescription& filter);

  /// How far from a pixel's centre a splat may lie and still count there, in pixels along each axis.
  float reach() const { return static_cast<float>(radius_); }

  /// Adds the splats of tasks, in their order. Uses threads; the sums' bits don't depend on how many.
  void add(std::span<const std::vector<Splat>> tasks);

  /// Adds the mean over `photons` photons to the channels R, G and B of a picture of the crop, and its variance, as if
  /// all splats were independent of each other, to those of their variances.
  void add_to(Image& image, std::uint64_t photons) const;

 private:
  friend void put_splats(BinaryOutput& out, const SplatFilm& film);
  friend void get_splats(BinaryInput& in, SplatFilm& film);

  void add_row(int y, const Splat& splat);

  PixelRect crop_;
  FilterDescription filter_;
  double radius_ = 0, scale_ = 0;       ///< the filter's, and one over its integral along one axis
  std::vector<double> sums_, squares_;  ///< per pixel, three each
};

}  // namespace sheaf

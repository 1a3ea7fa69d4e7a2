// Sums of a tile's samples, over its own pixels and over the surrounding pixels within the filter's reach.
#pragma once

#include "core/image/pixel_rect.h"
#include "core/soa/large_table.h"
#include "kernels/film/film_row.h"
#include "kernels/film/id_coverage.h"
#include "scene/tables/filter.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// Contributions of a tile to the pixels of other tiles.
struct FilmBorder {
  /// A rectangle of pixels and their rows of sums.
  struct Strip {
    PixelRect pixels;
    std::vector<double> sums;
    std::vector<IdCoverage> coverage;  ///< per pixel; only with surface ids
  };
  std::vector<Strip> strips;  ///< disjoint
};

/// Accumulator for one tile at a time; each worker has one. A pixel's sums depend only on the tile's samples and their
/// order.
class FilmTile {
 public:
  /// Begins the tile `own`. Pixels outside `crop` are ignored, although the tile's samples may lie there. `weights`:
  /// null if samples contribute only to their own pixel. `has_surface_ids`: samples have SurfaceSamples, whose coverage
  /// is summed.
  void begin(const FilmRow& row, const FilterWeights* weights, const PixelRect& own, const PixelRect& crop,
             bool has_surface_ids = false);

  /// Adds samples [first, first + count) of a buffer with the film's layout, which were taken in the tile's pixel (x,
  /// y). Skips dropped samples.
  void add(int x, int y, const SampleBuffer& samples, std::size_t first, std::size_t count);

  const PixelRect& own() const { return own_; }  ///< the tile's pixels inside the crop window
  /// Row of a pixel within reach, inside the crop window.
  const double* row(int x, int y) const { return sums_.data() + index(x, y) * row_.size(); }
  /// Coverage of a pixel within reach, inside the crop window. Requires has_surface_ids().
  const IdCoverage& coverage(int x, int y) const { return coverage_[index(x, y)]; }
  bool has_surface_ids() const { return !coverage_.empty(); }
  /// Number of samples taken in one of the own pixels, without dropped ones.
  std::uint32_t count(int x, int y) const { return counts_[index(x, y)]; }
  /// The sums of all pixels that are not the tile's own.
  FilmBorder border() const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - outer_.y0) * static_cast<std::size_t>(outer_.width()) +
           static_cast<std::size_t>(x - outer_.x0);
  }
  /// Writes the factors of a sample's weights and squared weights: the first two groups of a row.
  void take(const float* sample, double* terms) const;
  void add_alone(int x, int y, const SampleBuffer& samples, std::size_t sample);
  void add_together(int x, int y, const SampleBuffer& samples, std::size_t first, std::size_t count);
  void add_weighted(double* row, double weight) const;
  void cover(int x, int y, const SurfaceSample& surface, double weight);
  bool is_own(int x, int y) const { return x >= own_.x0 && x < own_.x1 && y >= own_.y0 && y < own_.y1; }

  FilmRow row_;
  const FilterWeights* weights_ = nullptr;
  PixelRect own_, outer_;
  LargeTable<double> sums_;  ///< aligned to registers unless the film has spectral bins
  std::vector<std::uint32_t> counts_;
  std::vector<IdCoverage> coverage_;  ///< per pixel; only with surface ids
  LargeTable<double> terms_;          ///< of the samples being added; see take()
};

}  // namespace sheaf

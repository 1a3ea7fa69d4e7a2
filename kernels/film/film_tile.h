// The sums of a tile's samples: over its own pixels, and over those around that its samples reach.
#pragma once

#include "core/large_table.h"
#include "core/pixel_rect.h"
#include "kernels/film/film_row.h"
#include "kernels/film/id_coverage.h"
#include "scene/tables/filter.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// What a tile adds to pixels of other tiles.
struct FilmBorder {
  /// Pixels side by side; their rows of sums.
  struct Strip {
    PixelRect pixels;
    std::vector<double> sums;
    std::vector<IdCoverage> coverage;  ///< of each pixel, where the film has it
  };
  std::vector<Strip> strips;  ///< disjoint
};

/// One for each worker. A pixel's sums depend on the tile's samples and on their order alone.
class FilmTile {
 public:
  /// Begins the tile `own`. Pixels outside `crop` are left out; the samples of the tile need not all lie inside.
  /// `weights`: null where samples count in their own pixel alone. `has_surface_ids`: whether samples have
  /// SurfaceSamples, which are summed up.
  void begin(const FilmRow& row, const FilterWeights* weights, const PixelRect& own, const PixelRect& crop,
             bool has_surface_ids = false);

  /// Adds `count` samples of a buffer with the film's layout, from `first` on, which were taken in the tile's pixel
  /// (x, y); nothing of those that were dropped.
  void add(int x, int y, const SampleBuffer& samples, std::size_t first, std::size_t count);

  const PixelRect& own() const { return own_; }  ///< the tile's pixels inside the crop
  /// The row of a pixel within reach, inside the crop.
  const double* row(int x, int y) const { return sums_.data() + index(x, y) * row_.size(); }
  /// Which surfaces cover a pixel within reach, inside the crop. Only where they are told.
  const IdCoverage& coverage(int x, int y) const { return coverage_[index(x, y)]; }
  bool has_surface_ids() const { return !coverage_.empty(); }
  /// How many samples were taken in one of the own pixels, and not dropped.
  std::uint32_t count(int x, int y) const { return counts_[index(x, y)]; }
  /// The sums of all pixels that are not the tile's own.
  FilmBorder border() const;

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - outer_.y0) * static_cast<std::size_t>(outer_.width()) +
           static_cast<std::size_t>(x - outer_.x0);
  }
  /// What the weights of a sample are multiplied by, and their squares: a row's first two groups.
  void take(const float* sample, double* terms) const;
  void add_alone(int x, int y, const SampleBuffer& samples, std::size_t sample);
  void add_together(int x, int y, const SampleBuffer& samples, std::size_t first, std::size_t count);
  void add_weighted(double* row, double weight) const;
  void cover(int x, int y, const SurfaceSample& surface, double weight);
  bool is_own(int x, int y) const { return x >= own_.x0 && x < own_.x1 && y >= own_.y0 && y < own_.y1; }

  FilmRow row_;
  const FilterWeights* weights_ = nullptr;
  PixelRect own_, outer_;
  LargeTable<double> sums_;  ///< aligned to registers, unless there are bins
  std::vector<std::uint32_t> counts_;
  std::vector<IdCoverage> coverage_;  ///< per pixel, where surfaces are told
  LargeTable<double> terms_;          ///< of the samples that are added; see take()
};

}  // namespace sheaf

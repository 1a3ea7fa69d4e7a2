#include "kernels/denoise/nl_means.h"

#include "core/simd/flush_denormals.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace sheaf {

namespace {

/// Tile size in pixels: the memory that one offset reads and updates fits the L2 cache.
constexpr int kTileWidth = 128, kTileHeight = 24;
/// Radius of the larger patch.
constexpr int kPatch = 3;
/// Number of rows of sums that are kept: a power of two, at least the side of the larger patch.
constexpr int kRing = 8;
/// Floats of a row of sums: one cache line before the first pixel, and padding for whole registers.
constexpr int kRowStart = 16, kRowSize = kRowStart + kTileWidth + 48;
/// Adjacent offsets along a row that are accumulated together, so that sums are loaded and stored once per group.
constexpr int kGroup = 7;
/// Sums per filter and half, over the pixels of the window with weights w, offsets (x, y) and colors c. A mean needs
/// sums of w c and w; a plane fit also needs the moments of the weights and of the weighted color.
enum Sum : int {
  kColor,                 ///< w c, three channels
  kWeight = kColor + 3,   ///< w
  kWeightX,               ///< w x
  kWeightY,               ///< w y
  kWeightXX,              ///< w x^2
  kWeightXY,              ///< w x y
  kWeightYY,              ///< w y^2
  kColorX,                ///< w c x, three channels
  kColorY = kColorX + 3,  ///< w c y, three channels
  kPlaneSums = kColorY + 3,
  kMeanSums = kWeightX
};
/// Sums of weights times the noise correlation between a pixel and the one at the offset. A plane fit also needs their
/// moments.
enum SharedSum : int { kShared, kSharedX, kSharedY, kPlaneShared, kMeanShared = kSharedX };
/// Ridge regularization of slopes, in weight times squared distance, so that few pixels do not tilt a plane.
constexpr float kRidge = 3.0f;
/// Factor on the color distances of the feature filter.
constexpr float kWeakColorFactor = 0.1f;

/// Whether a filter fits planes. Plane fits improve no image in filters that use only colors or only features.
constexpr bool fits_plane(int filter) { return filter == kSmallPatch || filter == kLargePatch; }

/// Approximation of exp(-x) for x >= 0 that is exactly 0 for x >= 16: (1 - x / 16)^16.
template <class F> SHEAF_INLINE F falloff(F x) {
  const F t = max(fma(x, F(-1.0f / 16), F(1.0f)), F(0.0f));
  const F t2 = t * t, t4 = t2 * t2, t8 = t4 * t4;
  return t8 * t8;
}

/// Filters one tile: for each offset of the window, computes the distances of pixels, sums them over patches and adds
/// the weighted pixels to the results.
template <class L, int kHalves> class TileFilter {
 public:
  using F = Float<L>;

  TileFilter(const NlMeansInput& input, const NlMeansSettings& settings, const PixelRect& tile)
      : in_(input),
        settings_(settings),
        tile_(tile),
        with_features_(!input.features.empty()),
        sums_(static_cast<std::size_t>(kTileHeight) * kAllSums * kTileWidth),
        shared_(static_cast<std::size_t>(kTileHeight) * kAllShared * kTileWidth) {}

  void run(std::vector<FilteredPlanes>& out) {
    const int r = settings_.radius;
    for (int dy = -r; dy <= r; ++dy) {
      if (tile_.y1 + dy <= 0 || tile_.y0 + dy >= in_.height) continue;
      int reach = r;
      while (reach * reach + dy * dy > r * (r + 1)) --reach;
      for (int dx = -reach; dx <= reach; dx += kGroup) add_offsets(dx, dy, std::min(kGroup, reach - dx + 1));
    }
    for (int y = tile_.y0; y < tile_.y1; ++y) write_row(y, out);
  }

 private:
  struct SumRow {
    alignas(kSimdAlignment) float values[kRowSize];
    float* at(int x) { return values + kRowStart + x; }
    const float* at(int x) const { return values + kRowStart + x; }
  };

  /// Rows of intermediate values of one offset.
  struct Offset {
    /// Ring buffers of rows of distances, summed over 3 and 7 pixels.
    SumRow small[kHalves][kRing], large[kHalves][kRing];
    SumRow small_distance[kHalves], large_distance[kHalves], weak_distance;
    SumRow feature, outside;  ///< distance by features; 0, or 1e30 if the other pixel is outside the image
  };

  /// Number of halves that a filter keeps apart.
  static constexpr int halves_of(int filter) { return std::min(filter == kFeatureFilter ? 1 : 2, kHalves); }
  /// Index of the first sum of a filter and half within a row, for sums_ or shared_.
  static constexpr int first_sum(int filter, int half, int mean_sums, int plane_sums) {
    int first = 0;
    for (int f = 0; f < filter; ++f) first += halves_of(f) * (fits_plane(f) ? plane_sums : mean_sums);
    return first + half * (fits_plane(filter) ? plane_sums : mean_sums);
  }
  static constexpr int kAllSums = first_sum(kMaxFilters, 0, kMeanSums, kPlaneSums),
                       kAllShared = first_sum(kMaxFilters, 0, kMeanShared, kPlaneShared);

  int width() const { return tile_.width(); }
  float* sums(int y, int filter, int half) {
    const int row = (y - tile_.y0) * kAllSums + first_sum(filter, half, kMeanSums, kPlaneSums);
    return sums_.data() + static_cast<std::ptrdiff_t>(row) * kTileWidth;
  }
  float* shared(int y, int filter, int half) {
    const int row = (y - tile_.y0) * kAllShared + first_sum(filter, half, kMeanShared, kPlaneShared);
    return shared_.data() + static_cast<std::ptrdiff_t>(row) * kTileWidth;
  }

  /// Adds the offsets (dx, dy) ... (dx + count - 1, dy).
  void add_offsets(int dx, int dy, int count) {
    for (int i = 0; i < count; ++i)
      for (int x = 0; x < kTileWidth; ++x) {
        const int other = tile_.x0 + x + dx + i;
        *offsets_[i].outside.at(x) = other >= 0 && other < in_.width ? 0.0f : 1e30f;
      }
    for (int y = tile_.y0 - kPatch; y < tile_.y1 + kPatch; ++y) {
      for (int i = 0; i < count; ++i) add_distance_row(offsets_[i], y, dx + i, dy);
      const int done = y - kPatch;
      if (done >= tile_.y0 && done + dy >= 0 && done + dy < in_.height) add_row(done, dx, dy, count);
    }
  }

  /// Computes the distances of a row of pixels, summed over 3 and 7 pixels of the row.
  void add_distance_row(Offset& offset, int y, int dx, int dy) {
    const std::ptrdiff_t start = tile_.x0 - kPatch;
    const float k2 = sqr(settings_.color_k);
    const F apart(1.0f - in_.correlation(dx, dy));
    SumRow raw[kHalves];
    // Find the rows of the pixels and of those at the offset
    const float *p[kHalves][3], *q[kHalves][3], *vp[3], *vq[3];
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      for (int h = 0; h < kHalves; ++h) {
        p[h][c] = in_.half[h][channel].row(y) + start;
        q[h][c] = in_.half[h][channel].row(y + dy) + start + dx;
      }
      vp[c] = in_.variance[channel].row(y) + start;
      vq[c] = in_.variance[channel].row(y + dy) + start + dx;
    }
    // Compute the distance of each pixel, the sum over the color channels
    for (int x = 0; x < width() + 2 * kPatch; x += L::width) {
      F distance[kHalves];
      for (int h = 0; h < kHalves; ++h) distance[h] = F(0.0f);
      for (int c = 0; c < 3; ++c) {
        const F a = load_at<L>(vp[c] + x), b = load_at<L>(vq[c] + x);
        // Subtract the expected noise and divide by the variance (equation 3 of Rousselle et al. 2012).
        const F noise = (a + min(a, b)) * apart;
        const F unit = F(1.0f) / fma(F(k2), a + b, F(in_.epsilon));
        for (int h = 0; h < kHalves; ++h) {
          const F d = load_at<L>(p[h][c] + x) - load_at<L>(q[h][c] + x);
          distance[h] = fma(fma(d, d, -noise), unit, distance[h]);
        }
      }
      for (int h = 0; h < kHalves; ++h) store_at(raw[h].at(x - kPatch), distance[h]);
    }
    // Sum distances along the row
    for (int h = 0; h < kHalves; ++h)
      sum_row(raw[h], offset.small[h][y & (kRing - 1)], offset.large[h][y & (kRing - 1)]);
  }

  void sum_row(const SumRow& raw, SumRow& small, SumRow& large) {
    for (int x = 1 - kPatch; x < width() + kPatch - 1; x += L::width)
      store_at(small.at(x), load_at<L>(raw.at(x - 1)) + load_at<L>(raw.at(x)) + load_at<L>(raw.at(x + 1)));
    for (int x = 0; x < width(); x += L::width)
      store_at(large.at(x), load_at<L>(small.at(x - 2)) + load_at<L>(raw.at(x)) + load_at<L>(small.at(x + 2)));
  }

  /// Mean distances of the patches around the pixels of a row.
  template <int kRadius> void patch_distances(const SumRow (&rows)[kRing], int y, SumRow& out) const {
    constexpr int kSide = 2 * kRadius + 1;
    for (int x = 0; x < width(); x += L::width) {
      F sum = load_at<L>(rows[(y - kRadius) & (kRing - 1)].at(x));
      for (int i = 1 - kRadius; i <= kRadius; ++i) sum += load_at<L>(rows[(y + i) & (kRing - 1)].at(x));
      store_at(out.at(x), sum * F(1.0f / (3 * kSide * kSide)));
    }
  }

  /// Computes the maximum distance over all features; at least 0, and 1e30 if the other pixel is outside the image.
  void measure_features(Offset& offset, int y, int dx, int dy) {
    std::copy(offset.outside.at(0), offset.outside.at(kTileWidth), offset.feature.at(0));
    for (const Feature& feature : in_.features) {
      if (!feature.slope_x.is_empty()) {
        measure_feature<1, true>(offset.feature, feature, y, dx, dy);
      } else {
        feature.channels.size() == 1 ? measure_feature<1, false>(offset.feature, feature, y, dx, dy)
                                     : measure_feature<3, false>(offset.feature, feature, y, dx, dy);
      }
    }
  }

  template <int kChannels, bool kSloped>
  void measure_feature(SumRow& out, const Feature& feature, int y, int dx, int dy) {
    const float *p[kChannels], *q[kChannels], *const scale = feature.scale.row(y) + tile_.x0;
    for (int c = 0; c < kChannels; ++c) {
      const Plane& plane = feature.channels[static_cast<std::size_t>(c)];
      p[c] = plane.row(y) + tile_.x0;
      q[c] = plane.row(y + dy) + tile_.x0 + dx;
    }
    const float* const slope_x = kSloped ? feature.slope_x.row(y) + tile_.x0 : nullptr;
    const float* const slope_y = kSloped ? feature.slope_y.row(y) + tile_.x0 : nullptr;
    for (int x = 0; x < width(); x += L::width) {
      F square(0.0f);
      for (int c = 0; c < kChannels; ++c) {
        F d = load_at<L>(q[c] + x) - load_at<L>(p[c] + x);
        if constexpr (kSloped) {
          d -=
              load_at<L>(slope_x + x) * F(static_cast<float>(dx)) + load_at<L>(slope_y + x) * F(static_cast<float>(dy));
        }
        square = fma(d, d, square);
      }
      store_at(out.at(x), max(load_at<L>(out.at(x)), square * load_at<L>(scale + x)));
    }
  }

  /// Adds the contribution of the offsets to a row of results.
  void add_row(int y, int dx, int dy, int count) {
    for (int i = 0; i < count; ++i) {
      Offset& offset = offsets_[i];
      measure_features(offset, y, dx + i, dy);
      for (int h = 0; h < kHalves; ++h) {
        patch_distances<1>(offset.small[h], y, offset.small_distance[h]);
        patch_distances<kPatch>(offset.large[h], y, offset.large_distance[h]);
      }
    }
    for (int h = 0; h < kHalves; ++h) {
      constexpr int kOther = kHalves - 1;  // each half uses the other half's weights
      const int other = h ^ kOther;
      add_weighted<kSmallPatch>(y, other, dx, dy, count, [=](Offset& o) { return &o.small_distance[h]; });
      add_weighted<kLargePatch>(y, other, dx, dy, count, [=](Offset& o) { return &o.large_distance[h]; });
      if (with_features_)
        add_weighted<kColorOnly>(y, other, dx, dy, count, [=](Offset& o) { return &o.large_distance[h]; });
    }
    if (!with_features_) return;
    for (int i = 0; i < count; ++i) weaken_distances(offsets_[i]);
    add_weighted<kFeatureFilter>(y, 0, dx, dy, count, [](Offset& o) { return &o.weak_distance; });
  }

  /// Computes the color distances of the feature filter: the mean of both halves, scaled down.
  void weaken_distances(Offset& offset) const {
    for (int x = 0; x < width(); x += L::width) {
      F sum(0.0f);
      for (const SumRow& row : offset.large_distance) sum += load_at<L>(row.at(x));
      store_at(offset.weak_distance.at(x), sum * F(kWeakColorFactor / kHalves));
    }
  }

  /// Sums over the offsets of a group, which all have the same y.
  struct GroupMean {
    F color[3] = {F(0.0f), F(0.0f), F(0.0f)}, weight = F(0.0f);
  };
  struct GroupPlane : GroupMean {
    F weight_x = F(0.0f), weight_xx = F(0.0f), color_x[3] = {F(0.0f), F(0.0f), F(0.0f)};
  };

  /// Adds the sums of a group to the sums of the filter. `sums`: those of a pixel.
  template <class Group> SHEAF_INLINE static void add_group(const Group& group, F offset_y, float* sums) {
    const auto add = [&](int k, F value) {
      float* const at = sums + k * kTileWidth;
      store_at(at, value + load_at<L>(at));
    };
    for (int c = 0; c < 3; ++c) add(kColor + c, group.color[c]);
    add(kWeight, group.weight);
    if constexpr (std::is_same_v<Group, GroupPlane>) {
      const F weight_y = group.weight * offset_y;
      add(kWeightX, group.weight_x);
      add(kWeightY, weight_y);
      add(kWeightXX, group.weight_xx);
      add(kWeightXY, group.weight_x * offset_y);
      add(kWeightYY, weight_y * offset_y);
      for (int c = 0; c < 3; ++c) {
        add(kColorX + c, group.color_x[c]);
        add(kColorY + c, group.color[c] * offset_y);
      }
    }
  }

  /// Adds the offsets to the sums of a filter for one half. `distance`: returns the row of distances of an offset.
  template <int kFilter, class Distance>
  SHEAF_INLINE void add_weighted(int y, int half, int dx, int dy, int count, Distance distance) {
    constexpr bool kPlane = fits_plane(kFilter);
    const float *color[kGroup][3], *second[kGroup][3], *distances[kGroup], *limits[kGroup];
    for (int i = 0; i < count; ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        color[i][c] = in_.half[half][c].row(y + dy) + tile_.x0 + dx + i;
        if constexpr (kFilter == kFeatureFilter && kHalves == 2)
          second[i][c] = in_.half[1][c].row(y + dy) + tile_.x0 + dx + i;
      }
      Offset& offset = offsets_[i];
      distances[i] = distance(offset)->at(0);
      limits[i] = (kFilter == kColorOnly ? offset.outside : offset.feature).at(0);
    }
    const F offset_y(static_cast<float>(dy));
    float* const sums_row = sums(y, kFilter, half);
    for (int x = 0; x < width(); x += L::width) {
      std::conditional_t<kPlane, GroupPlane, GroupMean> group;
      for (int i = 0; i < count; ++i) {
        const F weight = falloff(max(load_at<L>(distances[i] + x), load_at<L>(limits[i] + x)));
        const F offset_x(static_cast<float>(dx + i)), weight_x = weight * offset_x;
        group.weight += weight;
        if constexpr (kPlane) {
          group.weight_x += weight_x;
          group.weight_xx = fma(weight_x, offset_x, group.weight_xx);
        }
        for (int c = 0; c < 3; ++c) {
          F value = load_at<L>(color[i][c] + x);
          if constexpr (kFilter == kFeatureFilter && kHalves == 2) value += load_at<L>(second[i][c] + x);
          group.color[c] = fma(weight, value, group.color[c]);
          if constexpr (kPlane) group.color_x[c] = fma(weight_x, value, group.color_x[c]);
        }
      }
      add_group(group, offset_y, sums_row + x);
    }
    for (int i = 0; i < count; ++i)
      if (const float correlation = in_.correlation(dx + i, dy); correlation != 0)
        add_shared<kFilter>(shared(y, kFilter, half), correlation, dx + i, dy, distances[i], limits[i]);
  }

  /// Adds an offset to the sums of shared noise.
  template <int kFilter>
  void add_shared(float* sums_row, float correlation, int dx, int dy, const float* distances, const float* limits) {
    const float factors[kPlaneShared] = {correlation, correlation * static_cast<float>(dx),
                                         correlation * static_cast<float>(dy)};
    for (int x = 0; x < width(); x += L::width) {
      const F weight = falloff(max(load_at<L>(distances + x), load_at<L>(limits + x)));
      for (int k = 0; k < (fits_plane(kFilter) ? kPlaneShared : kMeanShared); ++k) {
        float* const at = sums_row + k * kTileWidth + x;
        store_at(at, fma(weight, F(factors[k]), load_at<L>(at)));
      }
    }
  }

  SHEAF_INLINE static void store_at(float* p, F value) {
    std::memcpy(p, static_cast<const void*>(&value), sizeof(float) * L::width);
  }

  void write_row(int y, std::vector<FilteredPlanes>& out) {
    for (int filter = 0; filter < (with_features_ ? kMaxFilters : kColorOnly); ++filter) {
      FilteredPlanes& planes = out[static_cast<std::size_t>(filter)];
      for (int x = 0; x < width(); ++x) {
        Result result;
        for (int h = 0; h < halves_of(filter); ++h) add_result(y, x, filter, h, result);
        for (std::size_t c = 0; c < 3; ++c) planes.color[c].at(tile_.x0 + x, y) = result.color[c] / kHalves;
        planes.self_weight.at(tile_.x0 + x, y) = result.self / static_cast<float>(halves_of(filter));
      }
    }
  }

  struct Result {
    float color[3] = {}, self = 0;
  };

  /// Adds the value at offset 0 of the weighted mean, or of the plane that minimizes the weighted squared error. The
  /// plane's value starts from the mean at the center of the weights and follows the slope back to the pixel. `across`
  /// is that step, multiplied by the inverse covariance of the weights. The step is clamped to the magnitude of the
  /// mean, because planes through few pixels are steep.
  void add_result(int y, int x, int filter, int half, Result& result) {
    const float *const sums_row = sums(y, filter, half) + x, *const shared_row = shared(y, filter, half) + x;
    const auto sum = [&](int k) { return sums_row[k * kTileWidth]; };
    const auto shared_sum = [&](int k) { return shared_row[k * kTileWidth]; };
    // Divide by the weights
    const float inverse_weight = 1 / sum(kWeight);
    float color[3], self = shared_sum(kShared) * inverse_weight;
    for (int c = 0; c < 3; ++c) color[c] = sum(kColor + c) * inverse_weight;
    if (fits_plane(filter)) {
      // Fit the plane: moments of the weights about their center
      const float center_x = sum(kWeightX) * inverse_weight, center_y = sum(kWeightY) * inverse_weight;
      const float xx = sum(kWeightXX) - center_x * sum(kWeightX) + kRidge,
                  xy = sum(kWeightXY) - center_x * sum(kWeightY),
                  yy = sum(kWeightYY) - center_y * sum(kWeightY) + kRidge;
      const float determinant = xx * yy - xy * xy;
      const float across_x = (yy * center_x - xy * center_y) / determinant,
                  across_y = (xx * center_y - xy * center_x) / determinant;
      // Step along the slope of each color from the center to the pixel
      for (int c = 0; c < 3; ++c) {
        const float step = across_x * (sum(kColorX + c) - center_x * sum(kColor + c)) +
                           across_y * (sum(kColorY + c) - center_y * sum(kColor + c));
        color[c] -= std::clamp(step, -std::abs(color[c]), std::abs(color[c]));
      }
      self -= across_x * (shared_sum(kSharedX) - center_x * shared_sum(kShared)) +
              across_y * (shared_sum(kSharedY) - center_y * shared_sum(kShared));
    }
    for (int c = 0; c < 3; ++c) result.color[c] += color[c];
    result.self += self;
  }

  const NlMeansInput& in_;
  const NlMeansSettings& settings_;
  const PixelRect tile_;
  const bool with_features_;
  LargeTable<float> sums_;    ///< per row of the tile, all sums one after the other
  LargeTable<float> shared_;  ///< like sums_, for weights times noise correlation
  Offset offsets_[kGroup];
};

}  // namespace

std::vector<FilteredPlanes> make_filtered_planes(const NlMeansInput& input) {
  std::vector<FilteredPlanes> out(input.features.empty() ? kColorOnly : kMaxFilters);
  for (FilteredPlanes& planes : out) {
    for (Plane& plane : planes.color) plane = Plane(input.width, input.height);
    planes.self_weight = Plane(input.width, input.height);
  }
  return out;
}

template <class L>
void nl_means_tile(const NlMeansInput& input, const NlMeansSettings& settings, const PixelRect& tile,
                   std::vector<FilteredPlanes>& out) {
  const FlushDenormals flush;
  input.halves == 2 ? TileFilter<L, 2>(input, settings, tile).run(out)
                    : TileFilter<L, 1>(input, settings, tile).run(out);
}

template void nl_means_tile<Wide>(const NlMeansInput&, const NlMeansSettings&, const PixelRect&,
                                  std::vector<FilteredPlanes>&);
template void nl_means_tile<Scalar>(const NlMeansInput&, const NlMeansSettings&, const PixelRect&,
                                    std::vector<FilteredPlanes>&);

std::vector<FilteredPlanes> nl_means(const NlMeansInput& input, const NlMeansSettings& settings) {
  std::vector<FilteredPlanes> out = make_filtered_planes(input);
  const int columns = (input.width + kTileWidth - 1) / kTileWidth,
            rows = (input.height + kTileHeight - 1) / kTileHeight;
  tbb::parallel_for(
      tbb::blocked_range<int>(0, columns * rows, 1),
      [&](const tbb::blocked_range<int>& range) {
        for (int i = range.begin(); i < range.end(); ++i) {
          const int x = i % columns * kTileWidth, y = i / columns * kTileHeight;
          nl_means_tile<Wide>(input, settings,
                              {x, y, std::min(x + kTileWidth, input.width), std::min(y + kTileHeight, input.height)},
                              out);
        }
      },
      tbb::simple_partitioner());
  return out;
}

}  // namespace sheaf

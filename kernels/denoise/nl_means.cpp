#include "kernels/denoise/nl_means.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Pixels of a tile: what one offset reads and adds to fits the L2 cache.
constexpr int kTileWidth = 128, kTileHeight = 40;
/// Half the side of the larger patch.
constexpr int kPatch = 3;
/// Rows of sums that are kept: a power of two, not less than the larger patch.
constexpr int kRing = 8;
/// Floats of a row of sums: in front of the first pixel as many as a cache line holds, and room for whole registers.
constexpr int kRowStart = 16, kRowSize = kRowStart + kTileWidth + 48;
/// Numbers that are summed per filter and half: the weighted colour and the weights.
constexpr int kSums = 4;

/// exp(-x) for 0 <= x, but exactly 0 from 16 on: (1 - x / 16)^16.
template <class F> SHEAF_INLINE F falloff(F x) {
  const F t = max(fma(x, F(-1.0f / 16), F(1.0f)), F(0.0f));
  const F t2 = t * t, t4 = t2 * t2, t8 = t4 * t4;
  return t8 * t8;
}

/// All offsets of the window over one tile: for each, the distances of pixels, their sums over patches, and what the
/// weights add to the results.
template <class L, int kHalves> class TileFilter {
 public:
  using F = Float<L>;

  TileFilter(const NlMeansInput& input, const NlMeansSettings& settings, const PixelRect& tile)
      : in_(input),
        settings_(settings),
        tile_(tile),
        with_features_(!input.features.empty()),
        sums_(static_cast<std::size_t>(kTileHeight) * kAllSums * kTileWidth) {}

  void run(std::vector<FilteredPlanes>& out) {
    const int r = settings_.radius;
    for (int dy = -r; dy <= r; ++dy) {
      if (tile_.y1 + dy <= 0 || tile_.y0 + dy >= in_.height) continue;
      for (int dx = -r; dx <= r; ++dx)
        if (dx * dx + dy * dy <= r * (r + 1)) add_offset(dx, dy);
    }
    for (int y = tile_.y0; y < tile_.y1; ++y) write_row(y, out);
  }

 private:
  static constexpr int kPatchSums = kSums * kHalves, kFeatureSums = kPatchSums * kFeatureOnly,
                       kAllSums = kFeatureSums + kSums;

  struct SumRow {
    alignas(kSimdAlignment) float values[kRowSize];
    float* at(int x) { return values + kRowStart + x; }
    const float* at(int x) const { return values + kRowStart + x; }
  };

  int width() const { return tile_.width(); }
  float* sums(int y, int k) {
    return sums_.data() +
           (static_cast<std::size_t>(y - tile_.y0) * kAllSums + static_cast<std::size_t>(k)) * kTileWidth;
  }

  void add_offset(int dx, int dy) {
    for (int x = 0; x < kTileWidth; ++x) {
      const int other = tile_.x0 + x + dx;
      *outside_.at(x) = other >= 0 && other < in_.width ? 0.0f : 1e30f;
    }
    for (int y = tile_.y0 - kPatch; y < tile_.y1 + kPatch; ++y) {
      add_distance_row(y, dx, dy);
      const int done = y - kPatch;
      if (done >= tile_.y0 && done + dy >= 0 && done + dy < in_.height) add_row(done, dx, dy);
    }
  }

  /// The distances of a row of pixels, summed over 3 and 7 pixels of the row.
  void add_distance_row(int y, int dx, int dy) {
    const std::ptrdiff_t start = tile_.x0 - kPatch;
    const float k2 = sqr(settings_.color_k);
    SumRow raw[kHalves];
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
    for (int x = 0; x < width() + 2 * kPatch; x += L::width) {
      F distance[kHalves];
      for (int h = 0; h < kHalves; ++h) distance[h] = F(0.0f);
      for (int c = 0; c < 3; ++c) {
        const F a = load_at<L>(vp[c] + x), b = load_at<L>(vq[c] + x);
        const F noise = a + min(a, b);
        const F unit = F(1.0f) / fma(F(k2), a + b, F(in_.epsilon));
        for (int h = 0; h < kHalves; ++h) {
          const F d = load_at<L>(p[h][c] + x) - load_at<L>(q[h][c] + x);
          distance[h] = fma(fma(d, d, -noise), unit, distance[h]);
        }
      }
      for (int h = 0; h < kHalves; ++h) store_at(raw[h].at(x - kPatch), distance[h]);
    }
    for (int h = 0; h < kHalves; ++h) sum_row(raw[h], small_[h][y & (kRing - 1)], large_[h][y & (kRing - 1)]);
  }

  void sum_row(const SumRow& raw, SumRow& small, SumRow& large) {
    for (int x = 1 - kPatch; x < width() + kPatch - 1; x += L::width)
      store_at(small.at(x), load_at<L>(raw.at(x - 1)) + load_at<L>(raw.at(x)) + load_at<L>(raw.at(x + 1)));
    for (int x = 0; x < width(); x += L::width)
      store_at(large.at(x), load_at<L>(small.at(x - 2)) + load_at<L>(raw.at(x)) + load_at<L>(small.at(x + 2)));
  }

  /// The mean distance of the patches around a pixel.
  template <int kRadius> SHEAF_INLINE F patch_distance(const SumRow (&rows)[kRing], int x, int y) const {
    F sum = load_at<L>(rows[(y - kRadius) & (kRing - 1)].at(x));
    for (int i = 1 - kRadius; i <= kRadius; ++i) sum += load_at<L>(rows[(y + i) & (kRing - 1)].at(x));
    constexpr int kSide = 2 * kRadius + 1;
    return sum * F(1.0f / (3 * kSide * kSide));
  }

  /// By how much features tell pixels apart, at least 0, and beyond all bounds where the other pixel is none.
  void measure_features(int y, int dx, int dy) {
    std::copy(outside_.at(0), outside_.at(kTileWidth), feature_.at(0));
    for (const Feature& feature : in_.features) {
      if (!feature.slope_x.is_empty()) {
        measure_feature<1, true>(feature, y, dx, dy);
      } else {
        feature.channels.size() == 1 ? measure_feature<1, false>(feature, y, dx, dy)
                                     : measure_feature<3, false>(feature, y, dx, dy);
      }
    }
  }

  template <int kChannels, bool kSloped> void measure_feature(const Feature& feature, int y, int dx, int dy) {
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
      store_at(feature_.at(x), max(load_at<L>(feature_.at(x)), square * load_at<L>(scale + x)));
    }
  }

  /// What the offset adds to a row of results.
  void add_row(int y, int dx, int dy) {
    measure_features(y, dx, dy);
    const float* q[kHalves][3];
    for (int h = 0; h < kHalves; ++h)
      for (int c = 0; c < 3; ++c) q[h][c] = in_.half[h][static_cast<std::size_t>(c)].row(y + dy) + tile_.x0 + dx;
    for (int x = 0; x < width(); x += L::width) {
      const F feature = load_at<L>(feature_.at(x));
      F color[kHalves][3];
      for (int h = 0; h < kHalves; ++h)
        for (int c = 0; c < 3; ++c) color[h][c] = load_at<L>(q[h][c] + x);
      for (int h = 0; h < kHalves; ++h) {
        constexpr int kOther = kHalves - 1;  // each half is weighed by the other
        const F* const other = color[h ^ kOther];
        const int first = kSums * (h ^ kOther);
        const F distance = patch_distance<kPatch>(large_[h], x, y);
        add_weighted(y, first, x, falloff(max(patch_distance<1>(small_[h], x, y), feature)), other);
        add_weighted(y, kPatchSums * kLargePatch + first, x, falloff(max(distance, feature)), other);
        if (!with_features_) continue;
        add_weighted(y, kPatchSums * kColorOnly + first, x, falloff(max(distance, load_at<L>(outside_.at(x)))), other);
      }
      if (!with_features_) continue;
      for (int h = 1; h < kHalves; ++h)
        for (int c = 0; c < 3; ++c) color[0][c] += color[h][c];
      add_weighted(y, kFeatureSums, x, falloff(feature), color[0]);
    }
  }

  SHEAF_INLINE void add_weighted(int y, int first, int x, F weight, const F* color) {
    for (int c = 0; c < 3; ++c) {
      float* const sum = sums(y, first + c) + x;
      store_at(sum, fma(weight, color[c], load_at<L>(sum)));
    }
    float* const sum = sums(y, first + 3) + x;
    store_at(sum, weight + load_at<L>(sum));
  }

  SHEAF_INLINE static void store_at(float* p, F value) {
    std::memcpy(p, static_cast<const void*>(&value), sizeof(float) * L::width);
  }

  void write_row(int y, std::vector<FilteredPlanes>& out) {
    for (int x = 0; x < width(); ++x) {
      for (int filter = 0; filter < (with_features_ ? kFeatureOnly : kColorOnly); ++filter) {
        FilteredPlanes& planes = out[static_cast<std::size_t>(filter)];
        float color[3] = {}, self = 0;
        for (int h = 0; h < kHalves; ++h) {
          const int first = filter * kPatchSums + kSums * h;
          const float share = 1 / (sums(y, first + 3)[x] * kHalves);
          for (int c = 0; c < 3; ++c) color[c] += sums(y, first + c)[x] * share;
          self += share;
        }
        write(planes, x, y, color, self);
      }
      if (!with_features_) continue;
      const float self = 1 / sums(y, kFeatureSums + 3)[x];
      float color[3];
      for (int c = 0; c < 3; ++c) color[c] = sums(y, kFeatureSums + c)[x] * (self / kHalves);
      write(out[kFeatureOnly], x, y, color, self);
    }
  }

  void write(FilteredPlanes& planes, int x, int y, const float* color, float self) {
    for (std::size_t c = 0; c < 3; ++c) planes.color[c].at(tile_.x0 + x, y) = color[c];
    planes.self_weight.at(tile_.x0 + x, y) = self;
  }

  const NlMeansInput& in_;
  const NlMeansSettings& settings_;
  const PixelRect tile_;
  const bool with_features_;
  LargeTable<float> sums_;  ///< rows of the tile, each with all its sums one after the other
  SumRow small_[kHalves][kRing], large_[kHalves][kRing];  ///< rows of distances summed over 3 and 7 pixels
  SumRow feature_, outside_;  ///< distance by features; 0, or beyond all bounds where the other pixel is none
};

}  // namespace

std::vector<FilteredPlanes> make_filtered_planes(const NlMeansInput& input) {
  std::vector<FilteredPlanes> out(input.features.empty() ? kColorOnly : kMostFilters);
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

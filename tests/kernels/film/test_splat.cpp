// Splats: their weights in pixels match those of camera samples at the same positions, also at the edge of the frame.
#include "kernels/film/splat.h"

#include "kernels/film/film.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace sheaf::test_splat {

namespace {

using Kind = PixelFilter::Kind;

constexpr PixelRect kFrame{0, 0, 7, 5};
/// Samples along each axis of a pixel.
constexpr int kSide = 16;

PixelFilter filter_of(Kind kind, float radius = 0.5f, float stddev = 0.5f) {
  PixelFilter filter;
  filter.kind = kind;
  filter.radius = radius;
  filter.stddev = stddev;
  return filter;
}

/// Filters whose edges coincide with sample positions: narrow, wide, and with negative lobes.
const std::vector<PixelFilter> kFilters = {
    filter_of(Kind::kBox),      filter_of(Kind::kBox, 0.25f), filter_of(Kind::kBox, 1.75f),
    filter_of(Kind::kTent, 1),  filter_of(Kind::kGaussian),   filter_of(Kind::kGaussian, 0, 2),
    filter_of(Kind::kMitchell), filter_of(Kind::kCatmullRom), filter_of(Kind::kLanczos)};

/// A non-uniform image, by raster position.
float value_at(float x, float y) { return 1.5f + std::sin(1.3f * x) + 0.4f * y * std::cos(0.9f * x); }

struct Sample {
  SampleOffset offset;
  float value;
};

/// Samples on a grid of size `width` in the center of a pixel.
std::vector<Sample> samples_of(int x, int y, double width) {
  std::vector<Sample> samples;
  const auto offset = [&](int i) { return static_cast<float>(width * ((i + 0.5) / kSide - 0.5)); };
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const SampleOffset at{offset(i), offset(j)};
      samples.push_back({at, value_at(static_cast<float>(x) + 0.5f + at.x, static_cast<float>(y) + 0.5f + at.y)});
    }
  return samples;
}

/// The image from camera samples of the sampled pixels.
Image by_film(const PixelFilter& filter, const PixelRect& sampled, const PixelRect& crop) {
  const FilterWeights weights(filter);
  Film film(kFrame.width(), kFrame.height(), crop, FilmLayout({{"R"}, {"G"}, {"B"}, {"A"}}));
  FilmTile tile;
  film.begin(tile, sampled, &weights);
  for (int y = sampled.y0; y < sampled.y1; ++y)
    for (int x = sampled.x0; x < sampled.x1; ++x) {
      const auto all = samples_of(x, y, std::min(2 * filter_radius(filter), 1.0));
      SampleBuffer buffer;
      buffer.resize(static_cast<int>(all.size()), 4, false);
      for (std::size_t i = 0; i < all.size(); ++i) {
        buffer.offset(i) = all[i].offset;
        for (int c = 0; c < 4; ++c) buffer[i][c] = all[i].value * static_cast<float>(c + 1);
      }
      tile.add(x, y, buffer, 0, all.size());
    }
  film.add(tile);
  return film.to_image();
}

/// The image from splats of the same light, which covers the film far beyond the sampled pixels.
Image by_splats(const PixelFilter& filter, FilterMode mode, const PixelRect& sampled, const PixelRect& crop) {
  const SplatFilter weights(filter, mode, sampled);
  const SplatFilter::Bounds bounds = weights.bounds(crop);
  const PixelRect lit = kFrame.grown(10);
  std::vector<std::vector<Splat>> splats(1);
  for (int y = lit.y0; y < lit.y1; ++y)
    for (int x = lit.x0; x < lit.x1; ++x)
      for (const Sample& sample : samples_of(x, y, 1)) {
        Splat splat;
        splat.x = static_cast<float>(x) + 0.5f + sample.offset.x,
        splat.y = static_cast<float>(y) + 0.5f + sample.offset.y;
        for (int c = 0; c < 3; ++c) splat.rgb[c] = sample.value * static_cast<float>(c + 1);
        if (splat.x > bounds.x0 && splat.x < bounds.x1 && splat.y > bounds.y0 && splat.y < bounds.y1)
          splats[0].push_back(splat);
      }
  SplatFilm film(crop);
  film.add(splats, weights);
  Image image(crop.width(), crop.height(), {"R", "G", "B"});
  film.add_to(image, kSide * kSide);  // samples per pixel area
  return image;
}

void check_same(const Image& a, const Image& b, double allowed) {
  REQUIRE(a.width == b.width);
  REQUIRE(a.height == b.height);
  double worst = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < 3; ++c)
        worst = std::max(worst, std::fabs(double{a.at(x, y, c)} - double{b.at(x, y, c)}) / (c + 1));
  CHECK(worst < allowed);
}

}  // namespace

TEST_CASE("splats: filter weights normalized by the sampled pixels reproduce the image of camera samples") {
  for (const PixelFilter& filter : kFilters)
    for (const bool border : {false, true})
      for (const PixelRect crop : {kFrame, PixelRect{0, 1, 3, 5}}) {
        CAPTURE(static_cast<int>(filter.kind));
        CAPTURE(filter.radius);
        CAPTURE(filter.stddev);
        CAPTURE(border);
        CAPTURE(crop.x1);
        const PixelRect sampled = kFrame.grown(border ? FilterWeights(filter).reach() : 0);
        check_same(by_splats(filter, FilterMode::kWeighted, sampled, crop), by_film(filter, sampled, crop), 3e-3);
      }
}

TEST_CASE("splats: weights by importance use the whole filter beyond the edge of the frame") {
  for (const PixelFilter& filter : kFilters) {
    CAPTURE(static_cast<int>(filter.kind));
    CAPTURE(filter.stddev);
    const PixelRect wide = kFrame.grown(FilterWeights(filter).reach());
    check_same(by_splats(filter, FilterMode::kImportance, kFrame, kFrame), by_film(filter, wide, kFrame), 3e-3);
  }
}

TEST_CASE("splats: a constant image is exactly constant up to its corners") {
  // Weights are piecewise linear over 1/256 of a pixel, so this grid is exact.
  constexpr int kFine = 256;
  for (const PixelFilter& filter : {filter_of(Kind::kTent, 1.37f), filter_of(Kind::kGaussian, 0, 0.31f),
                                    filter_of(Kind::kMitchell), filter_of(Kind::kLanczos)})
    for (const PixelRect sampled : {kFrame, kFrame.grown(2), PixelRect{0, 0, 1, 1}}) {
      const SplatFilter weights(filter, FilterMode::kWeighted, sampled);
      std::vector<double> sums(static_cast<std::size_t>(kFrame.width()));
      for (int i = sampled.x0 * kFine; i < sampled.x1 * kFine; ++i) {
        const auto span = weights.across((static_cast<float>(i) + 0.5f) / kFine, 0, std::min(sampled.x1, kFrame.x1));
        for (int k = 0; k < span.count; ++k) sums[static_cast<std::size_t>(span.first + k)] += span.weight(k) / kFine;
      }
      for (int x = 0; x < std::min(sampled.x1, kFrame.x1); ++x)
        CHECK(sums[static_cast<std::size_t>(x)] == near(1, 2e-5));
    }
}

}  // namespace sheaf::test_splat

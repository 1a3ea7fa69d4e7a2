// Samples that contribute to every pixel under the filter: films that are summed by tiles with borders, against direct
// sums over all samples.
#include "core/sampling/rng.h"
#include "kernels/film/film.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace sheaf::test_film_weights {

namespace {

using Kind = PixelFilter::Kind;

constexpr int kFrameWidth = 23, kFrameHeight = 17;
constexpr std::uint32_t kReplicates = 3, kPerReplicate = 2;

PixelFilter filter_of(Kind kind, float radius = 0.5f) {
  PixelFilter filter;
  filter.kind = kind;
  filter.radius = radius;
  return filter;
}

/// A sample of a pixel: its position and its values in two channels. The first channel has a variance.
struct Drawn {
  SampleOffset offset;
  float values[2];
};

Drawn draw_sample(int x, int y, std::uint32_t sample) {
  const auto u = random4<Scalar>(7, static_cast<std::uint32_t>(y * kFrameWidth + x), sample, 0);
  return {{u.x - 0.5f, u.y - 0.5f}, {u.z * static_cast<float>(1 + x % 5), u.w}};
}

const FilmLayout kLayout({{"R", true}, {"G", false}});

/// Adds all samples of all replicates, one replicate after the other, in square tiles of `side` pixels. `bins`: number
/// of spectral bins, 3 or 0; without bins the pixels are added by another function.
Film film_by_tiles(const FilterWeights& weights, const PixelRect& crop, int side, VarianceUnit unit, int bins = 3) {
  Film film(kFrameWidth, kFrameHeight, crop, kLayout, bins, unit);
  const PixelRect requested = crop.grown(weights.reach()).intersection({0, 0, kFrameWidth, kFrameHeight});
  for (std::uint32_t replicate = 0; replicate < kReplicates; ++replicate) {
    std::vector<FilmBorder> borders;
    for (int y0 = 0; y0 < kFrameHeight; y0 += side)
      for (int x0 = 0; x0 < kFrameWidth; x0 += side) {
        const PixelRect own{x0, y0, x0 + side, y0 + side}, pixels = own.intersection(requested);
        FilmTile tile;
        film.begin(tile, own, &weights);
        SampleBuffer samples;
        samples.resize(kPerReplicate, kLayout.size(), bins > 0);
        for (int y = pixels.y0; y < pixels.y1; ++y)
          for (int x = pixels.x0; x < pixels.x1; ++x) {
            for (std::uint32_t i = 0; i < kPerReplicate; ++i) {
              const Drawn drawn = draw_sample(x, y, replicate * kPerReplicate + i);
              samples.offset(i) = drawn.offset;
              std::memcpy(samples[i], drawn.values, sizeof drawn.values);
              if (bins > 0) samples.spectrum(i) = {{0, 1, 1, 2}, {drawn.values[0], 0.5f, 0.25f, drawn.values[1]}};
            }
            tile.add(x, y, samples, 0, kPerReplicate);
          }
        film.add(tile);
        borders.push_back(tile.border());
      }
    film.add(borders);
    film.end_replicate();
  }
  return film;
}

/// Expected values of a pixel by the definition in film.h.
struct Expected {
  double means[2], variance;
};

Expected expected_at(const PixelFilter& filter, int px, int py, VarianceUnit unit) {
  const double middle = evaluate_filter(filter, 0);
  std::vector<std::array<double, 3>> units;  // sum of weights, and weighted sums of both channels
  for (std::uint32_t sample = 0; sample < kReplicates * kPerReplicate; ++sample) {
    if (unit == VarianceUnit::kReplicate && sample % kPerReplicate == 0) units.push_back({});
    for (int y = 0; y < kFrameHeight; ++y)
      for (int x = 0; x < kFrameWidth; ++x) {
        const Drawn drawn = draw_sample(x, y, sample);
        const double w = evaluate_filter(filter, px - x - double(drawn.offset.x)) *
                         evaluate_filter(filter, py - y - double(drawn.offset.y)) / (middle * middle);
        if (unit == VarianceUnit::kSample) units.push_back({});
        auto& sums = units.back();
        sums[0] += w;
        for (int c = 0; c < 2; ++c) sums[1 + c] += w * double(drawn.values[c]);
      }
  }
  double sums[3] = {}, squares = 0, scatter = 0;
  for (const auto& u : units)
    for (int k = 0; k < 3; ++k) sums[k] += u[k];
  for (const auto& u : units) {
    const double off = u[1] - sums[1] / sums[0] * u[0];
    scatter += off * off;
    squares += u[0] * u[0];
  }
  return {{sums[1] / sums[0], sums[2] / sums[0]}, scatter / (sums[0] * sums[0] - squares)};
}

}  // namespace

TEST_CASE("weighted film: means and variances are those of all samples under the filter") {
  const PixelFilter filters[] = {filter_of(Kind::kBox),      filter_of(Kind::kBox, 0.8f), filter_of(Kind::kTent, 1),
                                 filter_of(Kind::kGaussian), filter_of(Kind::kMitchell),  filter_of(Kind::kLanczos)};
  for (const PixelFilter& filter : filters) {
    CAPTURE(static_cast<int>(filter.kind));
    const FilterWeights weights(filter);
    for (const auto& [unit, bins] :
         {std::pair{VarianceUnit::kSample, 3}, {VarianceUnit::kReplicate, 3}, {VarianceUnit::kReplicate, 0}}) {
      CAPTURE_BINDING(bins);
      const Image image = film_by_tiles(weights, {0, 0, kFrameWidth, kFrameHeight}, 8, unit, bins).to_image();
      REQUIRE(image.channels.size() == static_cast<std::size_t>(4 + bins));
      for (const auto& [x, y] : {std::pair{0, 0}, {7, 7}, {8, 8}, {22, 16}, {15, 3}, {10, 16}}) {
        const Expected expected = expected_at(filter, x, y, unit);
        CHECK(image.at(x, y, 0) == near(expected.means[0], 1e-4));
        CHECK(image.at(x, y, 1) == near(expected.means[1], 1e-4));
        CHECK(image.at(x, y, 2) == near(expected.variance, 1e-3));
        CHECK(image.at(x, y, 3) == kReplicates * kPerReplicate);
        // The second bin receives 0.5 + 0.25 from every sample; its width is 470 / 3 nm.
        if (bins > 0) CHECK(image.at(x, y, 5) == near(0.75 / (470.0 / 3), 1e-5));
      }
    }
  }
}

TEST_CASE("weighted film: a crop has the bits of the whole frame wherever it cuts tiles") {
  const FilterWeights weights(filter_of(Kind::kLanczos));
  CHECK(weights.reach() == 3);
  const Image whole = film_by_tiles(weights, {0, 0, kFrameWidth, kFrameHeight}, 8, VarianceUnit::kReplicate).to_image();
  for (const PixelRect crop : {PixelRect{8, 8, 16, 16}, {5, 3, 19, 11}, {9, 0, 10, 1}, {17, 10, 23, 17}}) {
    const Image part = film_by_tiles(weights, crop, 8, VarianceUnit::kReplicate).to_image();
    for (int y = 0; y < part.height; ++y)
      CHECK(std::memcmp(
                &part.data[static_cast<std::size_t>(y * part.width) * part.channels.size()],
                &whole.data[static_cast<std::size_t>((crop.y0 + y) * kFrameWidth + crop.x0) * part.channels.size()],
                static_cast<std::size_t>(part.width) * part.channels.size() * sizeof(float)) == 0);
  }
}

TEST_CASE("weighted film: tiles may be narrower than the filter radius") {
  const PixelFilter filter = filter_of(Kind::kLanczos);
  const Image small =
      film_by_tiles(FilterWeights(filter), {0, 0, kFrameWidth, kFrameHeight}, 2, VarianceUnit::kReplicate).to_image();
  for (const auto& [x, y] : {std::pair{0, 0}, {7, 7}, {12, 9}})
    CHECK(small.at(x, y, 0) == near(expected_at(filter, x, y, VarianceUnit::kReplicate).means[0], 1e-4));
}

TEST_CASE("weighted film: dropped samples have no weight in any pixel") {
  const FilterWeights weights(filter_of(Kind::kGaussian));
  // With replicates, several samples of a pixel are added at once.
  for (const VarianceUnit unit : {VarianceUnit::kSample, VarianceUnit::kReplicate}) {
    Film film(3, 1, {0, 0, 3, 1}, kLayout, 0, unit);
    FilmTile tile;
    film.begin(tile, {0, 0, 8, 8}, &weights);
    constexpr std::size_t kCount = 50;
    SampleBuffer samples;
    samples.resize(kCount, kLayout.size(), false);
    for (std::size_t i = 0; i < kCount; ++i) {
      samples.offset(i) = {0.1f, 0.2f};
      samples[i][0] = 4;
      samples[i][1] = i == 20 ? 1.0f : 0.0f;
      if (i % 3 == 1) samples.drop(i);
    }
    tile.add(0, 0, samples, 0, kCount);
    for (std::size_t i = 0; i < kCount; ++i) samples.drop(i);
    tile.add(1, 0, samples, 0, kCount);
    film.add(tile);
    film.end_replicate();
    const Image image = film.to_image();
    CHECK(film.count(0, 0) == 33);
    CHECK(film.count(1, 0) == 0);
    CHECK(image.at(1, 0, 0) == near(4));  // from the neighbor's samples
    CHECK(image.at(2, 0, 0) == near(4));
    CHECK(image.at(0, 0, 1) == near(1.0 / 33));
  }
}

}  // namespace sheaf::test_film_weights

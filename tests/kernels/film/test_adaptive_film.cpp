// Adaptive sampling's decisions about tiles, from samples that are made up.
#include "kernels/film/adaptive_film.h"
#include "kernels/film/aovs.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_adaptive_film {

namespace {

constexpr PixelRect kFrame{0, 0, 8, 8};

/// Expected number of samples of a tile after 8 samples per set, if only one half is noisy: one of its two sets is
/// twice as bright as the other, in `pixels`.
double expected_samples(int noisy_half, const PixelRect& pixels = kFrame, double target = 0.1) {
  const FilmLayout layout = film_layout({}, true);
  const Film film(kFrame.width(), kFrame.height(), kFrame, layout, 0, VarianceUnit::kReplicate);
  AdaptiveFilm adaptive(film, {kFrame}, 0, {target, 4096});
  SampleBuffer samples;
  FilmTile tile;
  while (adaptive.begin_round() && adaptive.taken_samples(0) < AdaptiveFilm::kSets * 8)
    for (std::size_t i = 0; i < adaptive.units().size(); ++i) {
      const AdaptiveUnit& unit = adaptive.units()[i];
      samples.resize(static_cast<int>(unit.samples), layout.size(), false);
      film.begin(tile, kFrame, nullptr);
      for (int y = 0; y < kFrame.height(); ++y)
        for (int x = 0; x < kFrame.width(); ++x) {
          const bool is_noisy = PixelRect{x, y, x + 1, y + 1}.intersection(pixels).area() > 0;
          const float value = is_noisy && unit.set == 2 * noisy_half ? 2.0f : 1.0f;
          for (std::size_t s = 0; s < unit.samples; ++s) std::fill_n(samples[s], layout.size(), value);
          tile.add(x, y, samples, 0, unit.samples);
        }
      adaptive.add(i, tile);
    }
  return adaptive.expected_samples(0);
}

}  // namespace

TEST_CASE("adaptive film: the noisier half decides how many samples a tile is expected to take") {
  // The relative variance of the noisy half, over the target of both, times the samples of a set. Sets are tested at
  // 8, 12, 16, 24, 32 and 48 samples.
  const double noise = 0.25 / (1.5 * 1.5 * 1.01), needed = 8 * noise / (2 * 0.1 * 0.1);
  REQUIRE(needed > 32);
  REQUIRE(needed < 48);
  CHECK(expected_samples(0) == 4 * 48);
  CHECK(expected_samples(1) == 4 * 48);
}

TEST_CASE("adaptive film: a single noisy pixel of a tile counts") {
  // Its level is the mean over 25 pixels.
  const double noise = 0.25 / (1.02 * 1.02 + 0.01) / 64, needed = 8 * noise / (2 * 0.03 * 0.03);
  REQUIRE(needed > 16);
  REQUIRE(needed < 24);
  CHECK(expected_samples(0, {3, 3, 4, 4}, 0.03) == 4 * 24);
}

}  // namespace sheaf::test_adaptive_film

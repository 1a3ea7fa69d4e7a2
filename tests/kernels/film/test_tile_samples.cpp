// The distribution of samples over the tiles of adaptive sampling.
#include "kernels/film/tile_samples.h"

#include "tests/support/near.h"

#include <doctest/doctest.h>

namespace sheaf::test_tile_samples {

namespace {

TileNoise tile(double variance, double samples = 8, bool is_final = false, double pixels = 256) {
  return {pixels, variance, variance, samples, is_final};
}

}  // namespace

TEST_CASE("tile samples: proportional to the square root of the variance, and enough for the image") {
  const std::vector<TileNoise> tiles{tile(1), tile(4), tile(9, 8, false, 128)};
  const double requested = 0.01;
  const std::vector<double> needed = needed_samples(tiles, requested, 1e9);
  REQUIRE(needed.size() == 3);
  CHECK(needed[1] == near(2 * needed[0]));
  CHECK(needed[2] == near(3 * needed[0]));
  const double remaining = 256 / needed[0] + 256 * 4 / needed[1] + 128 * 9 / needed[2];
  CHECK(remaining == near(requested * 640));
  // Fewer samples than equal ones, or than those of equal noise
  const double total = 256 * needed[0] + 256 * needed[1] + 128 * needed[2];
  CHECK(total < 0.9 * (256 + 256 * 4 + 128 * 9) / requested);
}

TEST_CASE("tile samples: no tile is more than twice as noisy as the image") {
  std::vector<TileNoise> tiles(99, tile(1));
  tiles.push_back(tile(400));
  const std::vector<double> needed = needed_samples(tiles, 0.01, 1e9);
  CHECK(needed[99] == near(400 / (kMaxTileNoise * kMaxTileNoise * 0.01)));
  CHECK(needed[0] < 0.5 * needed[99]);
}

TEST_CASE("tile samples: other tiles compensate for those that took too few or too many samples") {
  const double even = needed_samples(std::vector{tile(1), tile(1)}, 0.01, 1e9)[1];
  CHECK(even == near(100));
  CHECK(needed_samples(std::vector{tile(1, 80, true), tile(1)}, 0.01, 1e9)[1] == near(1 / (0.02 - 1 / 80.0)));
  CHECK(needed_samples(std::vector{tile(1, 200, true), tile(1)}, 0.01, 1e9)[1] == near(1 / (0.02 - 1 / 200.0)));
  // Within a bound: this tile alone has more noise than the target allows
  CHECK(needed_samples(std::vector{tile(1, 20, true), tile(1)}, 0.01, 1e9)[1] == near(150));
}

TEST_CASE("tile samples: bounded by the maximum, by the neighborhood, and none without noise") {
  const std::vector<double> needed = needed_samples(std::vector{tile(0), tile(5)}, 0.01, 64);
  CHECK(needed[0] == 0);
  CHECK(needed[1] == 64);
  TileNoise quiet = tile(1);
  quiet.spread_variance = 4;
  const std::vector<double> spread = needed_samples(std::vector{quiet, tile(4)}, 0.01, 1e9);
  CHECK(spread[0] == near(spread[1]));
}

}  // namespace sheaf::test_tile_samples

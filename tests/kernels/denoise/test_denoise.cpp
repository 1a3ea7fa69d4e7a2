// Denoising: features, fireflies, the selection of filters, and the channels of the result.
#include "core/io/error.h"
#include "kernels/denoise/denoise.h"
#include "kernels/denoise/features.h"
#include "kernels/denoise/fireflies.h"
#include "kernels/denoise/nl_means.h"
#include "kernels/denoise/select_filters.h"
#include "kernels/denoise/smooth_variance.h"
#include "tests/kernels/denoise/noisy_images.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace sheaf::test_denoise {

using namespace noisy_images;

TEST_CASE("the variance of a lamp does not affect its surroundings but that of a firefly does") {
  Planes3 variance, halves[2];
  for (std::size_t c = 0; c < 3; ++c) {
    variance[c] = halves[0][c] = halves[1][c] = Plane(20, 9);
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 20; ++x) {
        variance[c].at(x, y) = 0.01f;
        halves[0][c].at(x, y) = halves[1][c].at(x, y) = 1;
      }
    variance[c].at(4, 4) = variance[c].at(15, 4) = 9;
    halves[0][c].at(4, 4) = halves[1][c].at(4, 4) = 10;  // a lamp
    halves[0][c].at(15, 4) = 10;                         // in one half only
  }
  const Planes3 smooth = smooth_variance(variance, halves);
  CHECK(smooth[1].at(3, 4) == near(0.01));
  CHECK(smooth[1].at(4, 4) == near(0.3 * 9));
  CHECK(smooth[1].at(14, 4) == near((9 + 8 * 0.01) / 9));
  CHECK(smooth[1].at(0, 0) == near(0.01));
  CHECK(smooth_variance(variance, nullptr)[1].at(3, 4) == near((9 + 8 * 0.01) / 9));
}

TEST_CASE("features: vertical slopes are treated like horizontal ones") {
  // Inverse depth is linear on a plane; colors and normals are linear here too.
  constexpr int kSide = 24;
  const auto features_of = [&](float across, float down) {
    Image image(kSide, kSide, {"albedo.R", "albedo.G", "albedo.B", "N.X", "N.Y", "N.Z", "Z"});
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const float slope = across * static_cast<float>(x) + down * static_cast<float>(y);
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = 3 * slope, image.at(x, y, 3 + c) = 2 * slope;
        image.at(x, y, 6) = 1 / (0.5f + slope);
      }
    return find_features(image, NoiseCorrelation());
  };
  const float across = 0.03f, down = 0.01f;
  const std::vector<Feature> features = features_of(across, down), rotated = features_of(down, across);
  REQUIRE(features.size() == 3);
  for (int y = 1; y < kSide - 1; ++y)
    for (int x = 1; x < kSide - 1; ++x) {
      CHECK(features[2].slope_x.at(x, y) == near(across, 1e-3));
      CHECK(features[2].slope_y.at(x, y) == near(down, 1e-3));
      for (std::size_t i = 0; i < 3; ++i) CHECK(features[i].scale.at(x, y) == near(rotated[i].scale.at(y, x), 1e-3));
    }
  // Variation between pixels counts in both directions: three channels of 3 (across, down).
  CHECK(features[0].scale.at(5, 5) == near(1 / (1.2 * 1.2 * 27 * double{across * across + down * down}), 1e-3));
}

TEST_CASE("a vertical depth gradient is denoised as well as a horizontal one") {
  constexpr int kSide = 48;
  const auto error_of = [&](bool down) {
    Image image(kSide, kSide, {"R", "G", "B", "variance.R", "variance.G", "variance.B", "Z"});
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        // The same noise, transposed.
        const auto pixel = static_cast<std::uint32_t>(down ? x * kSide + y : y * kSide + x);
        for (int c = 0; c < 3; ++c) {
          image.at(x, y, c) = 1 + 0.2f * normal_number(pixel, static_cast<std::uint32_t>(c));
          image.at(x, y, 3 + c) = sqr(0.2f);
        }
        image.at(x, y, 6) = 1 / (0.2f + 0.05f * static_cast<float>(down ? y : x));
      }
    const Image denoised = denoise(image, Denoiser::kNlMeans).image;
    double sum = 0;
    for (const char* const name : {"denoised.R", "denoised.G", "denoised.B"})
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) sum += sqr(double{denoised.at(x, y, denoised.find_channel(name))} - 1);
    return sum / (3 * kSide * kSide);
  };
  const double across = error_of(false), down = error_of(true);
  CHECK(down == near(across, 0.02));
  // Depth does not separate pixels on one plane.
  CHECK(down < sqr(0.2) / 50);
}

TEST_CASE("denoising reduces the error and features reduce it further and the mean is preserved") {
  constexpr int kColumns = 96, kRows = 64;
  double before = 0, errors[2][2];
  for (const bool halves : {false, true})
    for (const bool normals : {false, true}) {
      const Image noisy = noisy_image(kColumns, kRows, halves, normals);
      const Image image = denoise(noisy, Denoiser::kNlMeans).image;
      before = squared_error(noisy, "", 0, kColumns);
      errors[halves][normals] = squared_error(image, "denoised.", 0, kColumns);
      double sum = 0, expected = 0;
      for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) {
          sum += image.at(x, y, image.find_channel("denoised.G"));
          expected += true_value(x, y, kColumns);
        }
      CHECK(std::abs(sum / expected - 1) < 5 * kNoise / std::sqrt(kColumns * kRows));
    }
  CHECK(before == near(sqr(kNoise), 0.1));
  CHECK(errors[0][0] < before / 5);
  CHECK(errors[1][0] < before / 8);
  CHECK(errors[1][1] < before / 20);
}

TEST_CASE("an edge below the noise level stays sharp where normals show it") {
  constexpr int kColumns = 96, kRows = 48;
  const Image with = denoise(noisy_image(kColumns, kRows, true, true), Denoiser::kNlMeans).image;
  const Image without = denoise(noisy_image(kColumns, kRows, true, false), Denoiser::kNlMeans).image;
  const double sharp = squared_error(with, "denoised.", kColumns / 2 - 2, kColumns / 2 + 2);
  CHECK(sharp < squared_error(without, "denoised.", kColumns / 2 - 2, kColumns / 2 + 2) / 2);
  CHECK(sharp < sqr(kNoise) / 10);
}

TEST_CASE("fireflies leave no blotches and features present in both halves survive") {
  constexpr int kSize = 48;
  const Image quiet = noisy_image(kSize, kSize, true, false);
  Image spiked = quiet;
  for (int c = 0; c < 3; ++c) {
    spiked.at(20, 20, c) += 500;  // in one half
    spiked.at(20, 20, 7 + c) += 1000;
    spiked.at(20, 20, 3 + c) = 250000;
    spiked.at(35, 30, c) = spiked.at(35, 30, 7 + c) = 50;  // in both
  }
  const Image image = denoise(spiked, Denoiser::kNlMeans).image, expected = denoise(quiet, Denoiser::kNlMeans).image;
  for (int c = 0; c < 3; ++c) {
    const int out = image.find_channel(std::string("denoised.") + "RGB"[c]);
    for (int y = 8; y < 26; ++y)  // out of reach of the other spike
      for (int x = 8; x < 24; ++x) CHECK(std::abs(image.at(x, y, out) - expected.at(x, y, out)) < 0.1f);
    CHECK(image.at(35, 30, out) == near(50, 0.02));
  }
}

/// Adds a bright sample of one half under the pixel filter, which covers 3 x 3 pixels.
void add_splat(Image& image, int x, int y, float excess) {
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i)
      for (int c = 0; c < 3; ++c) {
        const float part = excess * (i == 0 ? 1.0f : 0.5f) * (j == 0 ? 1.0f : 0.5f);
        image.at(x + i, y + j, c) += part / 2;
        image.at(x + i, y + j, 7 + c) += part;
        image.at(x + i, y + j, 3 + c) += sqr(part / 2);
      }
}

TEST_CASE("an isolated splat leaves no disc") {
  constexpr int kSize = 48;
  const Image quiet = noisy_image(kSize, kSize, true, false);
  Image spiked = quiet;
  add_splat(spiked, 14, 24, 20);
  add_splat(spiked, 14, 17, 3);  // a smaller one, and no company
  const Image image = denoise(spiked, Denoiser::kNlMeans).image, expected = denoise(quiet, Denoiser::kNlMeans).image;
  const int out = image.find_channel("denoised.G");
  for (int y = 4; y < kSize - 4; ++y)
    for (int x = 4; x < kSize / 2 - 2; ++x) CHECK(std::abs(image.at(x, y, out) - expected.at(x, y, out)) < 0.03f);
}

TEST_CASE("splats in company are kept, as they estimate light that few paths find") {
  constexpr int kSize = 64;
  Image spiked = noisy_image(kSize, kSize, true, false);
  double before = 0, after = 0;
  for (int y = 4; y < kSize - 4; y += 8)
    for (int x = 4; x < kSize - 4; x += 8) add_splat(spiked, x, y, 4);
  const Image image = denoise(spiked, Denoiser::kNlMeans).image;
  const int out = image.find_channel("denoised.G");
  for (int y = 16; y < kSize - 16; ++y)
    for (int x = 16; x < kSize - 16; ++x) {
      before += spiked.at(x, y, 1) - true_value(x, y, kSize);
      after += image.at(x, y, out) - true_value(x, y, kSize);
    }
  CHECK(after > 0.8 * before);
}

TEST_CASE("a firefly is detected by its variance without half buffers") {
  Planes3 color, variance;
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = Plane(9, 9);
    variance[c] = Plane(9, 9);
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 9; ++x) {
        color[c].at(x, y) = 1 + 0.01f * static_cast<float>(9 * y + x);
        variance[c].at(x, y) = 0.01f * color[c].at(x, y);
      }
    color[c].at(2, 2) = color[c].at(6, 6) = 100;
    variance[c].at(2, 2) = 99 * 99;
    variance[c].at(6, 6) = 1;
  }
  remove_fireflies(color, variance, nullptr);
  // The median of its neighbors replaces it.
  CHECK(color[0].at(2, 2) == color[0].at(3, 2));
  CHECK(variance[0].at(2, 2) == variance[0].at(3, 2));
  CHECK(color[0].at(6, 6) == 100);
}

TEST_CASE("the filter of least estimated error is selected") {
  constexpr int kSize = 40;
  Planes3 color, variance;
  std::vector<FilteredPlanes> filters(2);
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = variance[c] = filters[0].color[c] = filters[1].color[c] = Plane(kSize, kSize);
    filters[0].self_weight = filters[1].self_weight = Plane(kSize, kSize);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const float truth = x < kSize / 2 ? 1.f : 2.f;
        color[c].at(x, y) = truth + kNoise * normal_number(static_cast<std::uint32_t>(y * kSize + x), 20);
        variance[c].at(x, y) = sqr(kNoise);
        filters[0].color[c].at(x, y) = color[c].at(x, y);  // the identity
        filters[0].self_weight.at(x, y) = 1;
        filters[1].color[c].at(x, y) = 1;  // correct on the left, wrong on the right
      }
  }
  const Planes3 mixed = select_filters(filters, color, variance);
  for (int y = 0; y < kSize; ++y) {
    CHECK(mixed[1].at(3, y) == near(1));
    CHECK(mixed[1].at(kSize - 4, y) == near(color[1].at(kSize - 4, y)));
  }
}

TEST_CASE("denoising has the same bits on any number of threads and leaves other channels unchanged") {
  const Image noisy = noisy_image(150, 50, true, true);
  const DenoiseResult one = denoise(noisy, Denoiser::kNlMeans, 1), seven = denoise(noisy, Denoiser::kNlMeans, 7);
  CHECK(one.image.data.size() == seven.image.data.size());
  CHECK(std::memcmp(one.image.data.data(), seven.image.data.data(), one.image.data.size() * sizeof(float)) == 0);
  CHECK(one.description == "nlm: two halves, features N");
  for (std::size_t c = 0; c < noisy.channels.size(); ++c) CHECK(one.image.channels[c] == noisy.channels[c]);
  for (int y = 0; y < noisy.height; ++y)
    for (int x = 0; x < noisy.width; ++x)
      CHECK(std::memcmp(&one.image.data[static_cast<std::size_t>(y * 150 + x) * one.image.channels.size()],
                        &noisy.data[static_cast<std::size_t>(y * 150 + x) * noisy.channels.size()],
                        noisy.channels.size() * sizeof(float)) == 0);
  const DenoiseResult again = denoise(one.image, Denoiser::kNlMeans);
  CHECK(again.image.channels == one.image.channels);
  const Image displayed = denoised_only(one.image);
  CHECK(displayed.channels == std::vector<std::string>{"R", "G", "B"});
  CHECK(displayed.at(5, 5, 1) == one.image.at(5, 5, one.image.find_channel("denoised.G")));
}

TEST_CASE("denoising handles non-finite values and single pixels and missing variances") {
  Image noisy = noisy_image(40, 20, true, true);
  noisy.at(10, 10, 0) = std::numeric_limits<float>::infinity();
  noisy.at(11, 10, 4) = std::numeric_limits<float>::quiet_NaN();
  noisy.at(12, 10, 8) = -std::numeric_limits<float>::infinity();
  const Image image = denoise(noisy, Denoiser::kNlMeans).image;
  for (int c = 0; c < 3; ++c) {
    const int out = image.find_channel(std::string("denoised.") + "RGB"[c]);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 40; ++x) CHECK(std::isfinite(image.at(x, y, out)));
  }
  const Image tiny = noisy_image(1, 1, true, true);
  CHECK(denoise(tiny, Denoiser::kNlMeans).image.at(0, 0, tiny.find_channel("R")) == tiny.at(0, 0, 0));
  const Image bare(4, 4, {"R", "G", "B"});
  CHECK_THROWS_WITH_AS(denoise(bare, Denoiser::kNlMeans), doctest::Contains("--replicates"), Error);
}

}  // namespace sheaf::test_denoise

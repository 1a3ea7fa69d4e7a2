// Error metrics of images with known noise.
#include "core/image/image_compare.h"

#include "core/io/error.h"
#include "tests/support/near.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

namespace sheaf::test_image_compare {

namespace {

constexpr int kSize = 128;
constexpr float kNoise = 0.04f;

/// Values around `mean` times a gradient, with Gaussian noise of standard deviation kNoise.
Image make_noisy(float mean, unsigned seed) {
  Image image(kSize, kSize, {"R", "G", "B"});
  std::mt19937 generator(seed);
  std::normal_distribution<float> noise(0, kNoise);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      for (int c = 0; c < 3; ++c) {
        image.at(x, y, c) = mean * (0.5f + static_cast<float>(x) / kSize) + noise(generator);
      }
    }
  }
  return image;
}

Image constant_image(float value, int width = kSize, int height = kSize) {
  Image image(width, height, {"R", "G", "B"});
  for (float& v : image.data) v = value;
  return image;
}

CompareOptions known_variances() {
  CompareOptions options;
  options.variance_a = options.variance_b = constant_image(kNoise * kNoise);
  return options;
}

}  // namespace

TEST_CASE("a constant difference has the expected error figures") {
  const ImageComparison result = compare_images(constant_image(3), constant_image(2));
  CHECK(result.mse == near(1));
  CHECK(result.relative_mse == near(1 / 4.01));
  CHECK(result.mean_ratio == near(1.5));
  CHECK_FALSE(result.z_test);
  CHECK(compare_images(constant_image(0), constant_image(0)).mean_ratio == 1);
  CHECK(std::isinf(compare_images(constant_image(1), constant_image(0)).mean_ratio));
}

TEST_CASE("pure noise passes the Z-test at its level") {
  const ImageComparison result = compare_images(make_noisy(1, 1), make_noisy(1, 2), known_variances());
  REQUIRE(result.z_test);
  const ZTest& test = *result.z_test;
  const double n = 3.0 * kSize * kSize;
  CHECK(static_cast<double>(test.tests) == n);
  // Rejections are binomial with probability 0.01. 3.3 standard deviations are a significance level of 1e-3, two-sided.
  const double deviation = std::sqrt(0.01 * 0.99 / n);
  CHECK(std::abs(test.accepted_fraction() - 0.99) < 3.3 * deviation);
  CHECK(std::abs(test.mean_z_squared - 1) < 3.3 * std::sqrt(2 / n));
  CHECK(test.corrected_mean_p() > kSignificance);
  CHECK(result.mse == near(2 * kNoise * kNoise, 0.05));
}

TEST_CASE("a bias of two percent fails the Z-test") {
  const ImageComparison result = compare_images(make_noisy(1.02f, 1), make_noisy(1, 2), known_variances());
  REQUIRE(result.z_test);
  const double deviation = std::sqrt(0.01 * 0.99 / static_cast<double>(result.z_test->tests));
  CHECK(result.z_test->accepted_fraction() < 0.99 - 3.3 * deviation);
  CHECK(result.z_test->corrected_mean_p() < 1e-9);
  CHECK(std::abs(result.mean_ratio - 1.02) < 1e-3);
}

TEST_CASE("underestimated variances fail the Z-test") {
  CompareOptions options;
  options.variance_a = constant_image(kNoise * kNoise);  // treats the second image as noise-free
  const ImageComparison result = compare_images(make_noisy(1, 1), make_noisy(1, 2), options);
  CHECK(result.z_test->accepted_fraction() < 0.95);
  CHECK(result.z_test->mean_z_squared == near(2, 0.05));
}

TEST_CASE("values without variance must be equal") {
  CompareOptions options;
  options.variance_a = constant_image(0);
  Image b = constant_image(1);
  CHECK(compare_images(constant_image(1), b, options).z_test->accepted_fraction() == 1);
  b.at(3, 4, 1) = 1.01f;
  const ZTest test = *compare_images(constant_image(1), b, options).z_test;
  CHECK(test.accepted == test.tests - 1);
}

TEST_CASE("NaN and infinity are counted and excluded") {
  Image a = constant_image(1);
  a.at(0, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  a.at(1, 0, 2) = std::numeric_limits<float>::infinity();
  const ImageComparison result = compare_images(a, constant_image(1));
  CHECK(result.non_finite == 2);
  CHECK(result.mse == 0);
}

TEST_CASE("a crop is compared with the same region of the whole image") {
  const Image whole = make_noisy(1, 5);
  Image crop(20, 10, {"R", "G", "B"});
  crop.x0 = 30;
  crop.y0 = 40;
  crop.frame_width = crop.frame_height = kSize;
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 20; ++x) {
      for (int c = 0; c < 3; ++c) crop.at(x, y, c) = whole.at(x + 30, y + 40, c);
    }
  }
  const ImageComparison result = compare_images(crop, whole);
  CHECK(result.width == 20);
  CHECK(result.height == 10);
  CHECK(result.mse == 0);
  crop.x0 = 200;
  CHECK_THROWS_AS(compare_images(crop, whole), Error);
}

TEST_CASE("images that cannot be compared are usage errors") {
  CHECK_THROWS_AS(compare_images(constant_image(1), constant_image(1, 64, 64)), Error);
  CHECK_THROWS_AS(compare_images(constant_image(1), Image(kSize, kSize, {"R", "G"})), Error);
  CompareOptions options;
  options.variance_a = constant_image(1, 64, 64);
  CHECK_THROWS_AS(compare_images(constant_image(1), constant_image(1), options), Error);
}

TEST_CASE("variance layers are read as an image") {
  Image image(2, 1, {"R", "variance.B", "variance.G", "variance.R"});
  CHECK_FALSE(variance_layers(Image(2, 1, {"R", "variance.R"})));
  image.at(1, 0, 3) = 5;
  image.x0 = 7;
  const std::optional<Image> variance = variance_layers(image);
  REQUIRE(variance);
  CHECK(variance->at(1, 0, 0) == 5);
  CHECK(variance->x0 == 7);
}

}  // namespace sheaf::test_image_compare

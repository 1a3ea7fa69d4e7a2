// Automatic exposure: which pixels count, and invariance to the scale of the image.
#include "core/color/color.h"
#include "core/image/display_transform.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

namespace sheaf::test_auto_exposure {

namespace {

constexpr int kSize = 64;

/// A square image in gray.
Image square_image() { return {kSize, kSize, {"R", "G", "B"}}; }

void set(Image& image, int x, int y, float value) {
  for (int c = 0; c < 3; ++c) image.at(x, y, c) = value;
}

/// A disc of radiance 0.09 in front of `background`, filtered by a Gaussian of standard deviation `sigma` (pixels; 0:
/// not filtered), to good approximation for large discs.
Image disc(double radius, double sigma, float background = 0) {
  Image image = square_image();
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double distance = std::hypot(x - 31.3, y - 32.4) - radius;
      const double covered = sigma > 0       ? 0.5 * std::erfc(distance / (sigma * std::sqrt(2.0)))
                             : distance <= 0 ? 1.0
                                             : 0.0;
      const double value = 0.09 * covered;
      set(image, x, y, std::max(static_cast<float>(value), background));
    }
  return image;
}

double gray_exposure(float value) { return std::log2(0.18 / static_cast<double>(value)); }

Image scaled(Image image, float factor) {
  for (std::size_t i = 0; i < image.data.size(); ++i)
    if (image.channels[i % image.channels.size()] != "A") image.data[i] *= factor;
  return image;
}

}  // namespace

TEST_CASE("auto exposure: faint pixels around a bright spot do not count") {
  const double expected = gray_exposure(0.09f);
  CHECK(auto_exposure(disc(12, 0)) == within(expected, 1e-5));
  // What denoisers and filters leave in all other pixels, nearly 90 % of the image
  for (const float residue : {1e-44f, 1e-36f, 1e-30f, 1e-20f, 1e-12f, 1e-8f, 1e-7f}) {
    CAPTURE(residue);
    CHECK(auto_exposure(disc(12, 0, residue)) == within(expected, 1e-5));
  }
  // A small spot with residue in 99 % of the image
  CHECK(auto_exposure(disc(3.5, 0, 1e-10f)) == within(expected, 1e-5));
  // Tails of a Gaussian filter count as long as they are visible: a ring of 1.6 pixels, on average 4.5 stops darker
  CHECK(auto_exposure(disc(12, 0.5)) == within(expected, 1));
  CHECK(auto_exposure(disc(24, 0.5)) == within(expected, 0.55));
  CHECK(auto_exposure(disc(12, 0.5)) > expected);
}

TEST_CASE("auto exposure: the bright part decides which pixels are faint, not the brightest pixel") {
  // A disc of the sun, a millionth of the luminance of which the landscape has
  Image sunny = square_image();
  for (float& value : sunny.data) value = 0.5f;
  set(sunny, 10, 10, 5e5f);
  const double sun_stops = std::log2(1e6) / (kSize * kSize);
  CHECK(auto_exposure(sunny) == within(gray_exposure(0.5f) - sun_stops, 1e-5));
  // A dark room with a window that takes 5 % of the image: 8 stops brighter, and the room counts
  Image room = square_image();
  for (int i = 0; i < kSize * kSize; ++i) set(room, i % kSize, i / kSize, i % 20 == 0 ? 2.56f : 0.01f);
  const double window = 205.0 / (kSize * kSize);
  CHECK(auto_exposure(room) == within(gray_exposure(0.01f) - 8 * window, 1e-3));
}

TEST_CASE("auto exposure: a factor changes the exposure by its logarithm") {
  Image covered(4, 1, {"R", "G", "B", "A"});
  covered.data = {0.1f, 0.2f, 0.3f, 0.5f, 0.4f, 0.1f, 0.2f, 0, 0.01f, 0.02f, 0.03f, 0.001f, 1e-9f, 1e-9f, 1e-9f, 1};
  for (const Image& image : {disc(12, 1), disc(5, 9, 1e-25f), covered})
    for (const float factor : {1e-6f, 1e-3f, 0.7f, 30.0f, 1e6f}) {
      CAPTURE(factor);
      CHECK(auto_exposure(scaled(image, factor)) ==
            within(auto_exposure(image) - std::log2(static_cast<double>(factor)), 1e-5));
    }
}

TEST_CASE("auto exposure: coverage, and values that do not count") {
  const auto exposure_of = [](std::vector<std::string> channels, std::vector<float> pixels) {
    const auto width = static_cast<int>(pixels.size() / channels.size());
    Image image(width, 1, std::move(channels));
    image.data = std::move(pixels);
    return auto_exposure(image);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  CHECK(exposure_of({"Y"}, {0.045f}) == within(2, 1e-6));
  CHECK(exposure_of({"Y"}, {0}) == 0.0);
  CHECK(exposure_of({"Y"}, {-1}) == 0.0);
  CHECK(exposure_of({"R", "G", "B"}, {0, 0, 0, 0, 0, 0}) == 0.0);
  CHECK(exposure_of({"R", "G", "B"}, {nan, 1, 1, inf, 0, 0, -inf, 0, 0, -5, 0, 0, 0.09f, 0.09f, 0.09f}) ==
        within(1, 1e-6));
  CHECK(exposure_of({"R", "G", "B"}, {inf, -inf, 0}) == 0.0);
  // Residue without coverage, as denoisers leave it around an object, in eight pixels
  std::vector<float> object{0.02f, 0.02f, 0.02f, 0.5f};
  for (int i = 0; i < 8; ++i) object.insert(object.end(), {1e-12f, 1e-12f, 1e-12f, i % 2 == 0 ? 0.0f : 1e-6f});
  CHECK(exposure_of({"R", "G", "B", "A"}, object) == within(gray_exposure(0.04f), 1e-5));
  // Light without coverage, as of a flame, counts as it appears over black
  CHECK(exposure_of({"R", "G", "B", "A"}, {0.02f, 0.02f, 0.02f, 0, 0.08f, 0.08f, 0.08f, 0.001f}) ==
        within(gray_exposure(0.04f), 1e-5));
  // The exposure of the faintest images is finite as a factor
  CHECK(std::isfinite(std::exp2(static_cast<float>(exposure_of({"Y"}, {1e-45f})))));
  CHECK(exposure_of({"Y"}, {std::numeric_limits<float>::max()}) == within(std::log2(0.18) - 128, 1e-4));
}

}  // namespace sheaf::test_auto_exposure

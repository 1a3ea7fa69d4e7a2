// Noisy images of a known noise-free image, for tests of denoising.
#pragma once

#include "core/image/image.h"
#include "core/sampling/rng.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace sheaf::noisy_images {

/// A normally distributed number of mean 0 and variance 1.
inline float normal_number(std::uint32_t pixel, std::uint32_t what) {
  const auto u = random4<Scalar>(7, pixel, what, 0);
  return std::sqrt(-2 * std::log(u.x + 1e-9f)) * std::cos(2 * kPi * u.y);
}

/// The noise-free image: a slope, and a step at the middle column that the normals show.
inline float true_value(int x, int y, int width) {
  return 0.5f + 0.004f * static_cast<float>(y) + (x < width / 2 ? 0.f : 0.1f);
}

/// Standard deviation of the mean of all samples.
inline constexpr float kNoise = 0.1f;

/// An image with noise of known variance, with or without half buffers and normals.
inline Image noisy_image(int width, int height, bool halves, bool normals) {
  std::vector<std::string> names = {"R", "G", "B", "variance.R", "variance.G", "variance.B", "other"};
  if (halves) names.insert(names.end(), {"half.R", "half.G", "half.B"});
  if (normals) names.insert(names.end(), {"N.X", "N.Y", "N.Z"});
  Image image(width, height, names);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto pixel = static_cast<std::uint32_t>(y * width + x);
      for (int c = 0; c < 3; ++c) {
        const auto what = static_cast<std::uint32_t>(2 * c);
        const float a = normal_number(pixel, what) * kNoise * std::sqrt(2.f);
        const float b = normal_number(pixel, what + 1) * kNoise * std::sqrt(2.f);
        image.at(x, y, c) = true_value(x, y, width) + (a + b) / 2;
        image.at(x, y, 3 + c) = sqr(kNoise);
        if (halves) image.at(x, y, 7 + c) = true_value(x, y, width) + a;
      }
      image.at(x, y, 6) = static_cast<float>(pixel);
      if (normals) image.at(x, y, image.find_channel(x < width / 2 ? "N.X" : "N.Y")) = 1;
    }
  return image;
}

/// Mean squared error of the channels `prefix`R, G and B over columns [x0, x1).
inline double squared_error(const Image& image, const std::string& prefix, int x0, int x1) {
  double sum = 0;
  for (const char* color : {"R", "G", "B"}) {
    const int c = image.find_channel(prefix + color);
    REQUIRE(c >= 0);
    for (int y = 0; y < image.height; ++y)
      for (int x = x0; x < x1; ++x) sum += sqr(image.at(x, y, c) - true_value(x, y, image.width));
  }
  return sum / (3.0 * image.height * (x1 - x0));
}

}  // namespace sheaf::noisy_images

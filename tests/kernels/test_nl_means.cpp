// Denoising: non-local means against their definition, fireflies, features, and the channels of the result.
#include "core/error.h"
#include "core/rng.h"
#include "kernels/denoise/denoise.h"
#include "kernels/denoise/features.h"
#include "kernels/denoise/fireflies.h"
#include "kernels/denoise/nl_means.h"
#include "kernels/denoise/noise_correlation.h"
#include "kernels/denoise/select_filters.h"
#include "kernels/denoise/smooth_variance.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace sheaf::test_nl_means {

namespace {

/// A normally distributed number of mean 0 and variance 1.
float normal_number(std::uint32_t pixel, std::uint32_t what) {
  const auto u = random4<Scalar>(7, pixel, what, 0);
  return std::sqrt(-2 * std::log(u.x + 1e-9f)) * std::cos(2 * kPi * u.y);
}

/// The noise-free image: a slope, and a step at the middle column that the normals show.
float true_value(int x, int y, int width) {
  return 0.5f + 0.004f * static_cast<float>(y) + (x < width / 2 ? 0.f : 0.1f);
}

constexpr float kNoise = 0.1f;  // standard deviation of the mean of all samples

/// An image with noise of known variance, with or without half buffers and normals.
Image noisy_picture(int width, int height, bool halves, bool normals) {
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
double squared_error(const Image& image, const std::string& prefix, int x0, int x1) {
  double sum = 0;
  for (const char* color : {"R", "G", "B"}) {
    const int c = image.find_channel(prefix + color);
    REQUIRE(c >= 0);
    for (int y = 0; y < image.height; ++y)
      for (int x = x0; x < x1; ++x) sum += sqr(image.at(x, y, c) - true_value(x, y, image.width));
  }
  return sum / (3.0 * image.height * (x1 - x0));
}

/// An input of noise around 1, with a feature that has a step at one column.
NlMeansInput noisy_input(int width, int height, int halves) {
  NlMeansInput input;
  input.width = width;
  input.height = height;
  input.halves = halves;
  std::uint32_t what = 0;
  const auto fill = [&](Plane& plane, auto value) {
    plane = Plane(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        plane.at(x, y) = value(x, normal_number(static_cast<std::uint32_t>(y * width + x), what));
    plane.extend();
    ++what;
  };
  for (int h = 0; h < halves; ++h)
    for (Plane& plane : input.half[h])
      fill(plane, [](int x, float n) { return 1 + 0.01f * static_cast<float>(x) + 0.1f * n; });
  for (Plane& plane : input.variance) fill(plane, [](int, float n) { return 0.01f * (1 + 0.3f * std::abs(n)); });
  Feature& feature = input.features.emplace_back();
  fill(feature.channels.emplace_back(), [&](int x, float) { return x < width / 3 ? 0.f : 1.f; });
  fill(feature.scale, [](int, float) { return 3.f; });
  return input;
}

/// Noise of variance 1 that is correlated between pixels. It is white noise filtered by 1 2 1 along rows and summed
/// over two rows, the lower one shifted to the right. Its correlation is 2 / 3 with the next pixel of the row and 1 / 6
/// with the one after that. It is half of that around the pixel to the lower right.
Plane correlated_noise(int width, int height, std::uint32_t what) {
  const double weights[] = {1 / std::sqrt(12.0), 2 / std::sqrt(12.0), 1 / std::sqrt(12.0)};
  Plane plane(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 3; ++i)
          plane.at(x, y) += static_cast<float>(weights[i]) *
                            normal_number(static_cast<std::uint32_t>((y + j) * (width + 3) + x + i + j), what);
  plane.extend();
  return plane;
}

/// The noise correlation that is estimated from two halves with such noise.
NoiseCorrelation find_correlation(int width, int height) {
  Planes3 half[2], variance;
  for (std::size_t c = 0; c < 3; ++c) {
    variance[c] = Plane(width, height);
    for (int y = 0; y < height; ++y) std::fill_n(variance[c].row(y), width, 1.0f);
    for (std::uint32_t h = 0; h < 2; ++h)
      half[h][c] = correlated_noise(width, height, 40 + 3 * h + static_cast<std::uint32_t>(c));
  }
  return NoiseCorrelation(half[0], half[1], variance);
}

/// A pixel p and another, q.
struct Pair {
  int px, py, qx, qy;
};

/// The patch distance of two pixels in one half by the definition, in double precision. Patches beyond the image repeat
/// its border.
double patch_distance(const NlMeansInput& in, int half, float color_k, const Pair& pair, int radius) {
  const auto [px, py, qx, qy] = pair;
  double sum = 0;
  for (int j = -radius; j <= radius; ++j)
    for (int i = -radius; i <= radius; ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const double d = in.half[half][c].at(px + i, py + j) - in.half[half][c].at(qx + i, qy + j);
        const double a = in.variance[c].at(px + i, py + j), b = in.variance[c].at(qx + i, qy + j);
        const double noise = (a + std::min(a, b)) * (1 - in.correlation(qx - px, qy - py));
        sum += (d * d - noise) / (in.epsilon + color_k * color_k * (a + b));
      }
  const int side = 2 * radius + 1;
  return sum / (3 * side * side);
}

/// The filter weight of q for p when the given half is averaged.
double pair_weight(const NlMeansInput& in, NlMeansFilter filter, int half, const Pair& pair) {
  const double f = in.features[0].channels[0].at(pair.px, pair.py) - in.features[0].channels[0].at(pair.qx, pair.qy);
  const double feature = f * f * in.features[0].scale.at(pair.px, pair.py);
  const auto distance = [&](int h) { return patch_distance(in, h, 0.5f, pair, filter == kSmallPatch ? 1 : 3); };
  const int by = in.halves == 2 ? 1 - half : 0;
  double most = std::max(0.0, distance(by));
  if (filter == kMostlyFeatures)
    most = std::max(0.0, 0.1 * (in.halves == 2 ? (distance(0) + distance(1)) / 2 : distance(0)));
  if (filter != kColorOnly) most = std::max(most, feature);
  return std::pow(std::max(1 - most / 16, 0.0), 16);
}

/// Filtered value of a pixel in one half, and the correlation of its noise with that of the pixel itself.
struct Expected {
  double value, self;
};

/// By the definition: the weighted mean, or the weighted least-squares plane, whose slopes are regularised by 3 pixels
/// squared.
Expected expected_result(const NlMeansInput& in, NlMeansFilter filter, int half, int px, int py) {
  struct Pixel {
    double dx, dy, weight, value, correlation;
  };
  std::vector<Pixel> pixels;
  for (int qy = std::max(py - 4, 0); qy <= std::min(py + 4, in.height - 1); ++qy)
    for (int qx = std::max(px - 4, 0); qx <= std::min(px + 4, in.width - 1); ++qx) {
      if (sqr(qx - px) + sqr(qy - py) > 4 * 5) continue;  // a disk
      pixels.push_back({static_cast<double>(qx - px), static_cast<double>(qy - py),
                        pair_weight(in, filter, half, {px, py, qx, qy}), in.half[half][1].at(qx, qy),
                        in.correlation(qx - px, qy - py)});
    }
  // Gauss elimination of the normal equations for 1, x and y. The right side is the first column of the identity
  // matrix.
  double m[3][4] = {{0, 0, 0, 1}, {0, 3, 0, 0}, {0, 0, 3, 0}};
  for (const Pixel& q : pixels) {
    const double terms[] = {1, q.dx, q.dy};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m[i][j] += q.weight * terms[i] * terms[j];
  }
  if (filter == kColorOnly || filter == kMostlyFeatures) m[0][1] = m[0][2] = m[1][0] = m[2][0] = 0;
  for (int i = 0; i < 3; ++i)
    for (int row = 0; row < 3; ++row) {
      if (row == i) continue;
      const double factor = m[row][i] / m[i][i];
      for (int j = 0; j < 4; ++j) m[row][j] -= factor * m[i][j];
    }
  Expected expected{0, 0};
  for (const Pixel& q : pixels) {
    const double share = q.weight * (m[0][3] / m[0][0] + q.dx * m[1][3] / m[1][1] + q.dy * m[2][3] / m[2][2]);
    expected.value += share * q.value;
    expected.self += share * q.correlation;
  }
  return expected;
}

}  // namespace

TEST_CASE("NL-means matches its definition with each half weighted by the other") {
  const NlMeansSettings settings{4, 0.5f};
  for (const bool correlated : {false, true})
    for (const int halves : {1, 2}) {
      NlMeansInput input = noisy_input(21, 13, halves);
      if (correlated) input.correlation = find_correlation(64, 64);
      const std::vector<FilteredPlanes> filtered = nl_means(input, settings);
      REQUIRE(filtered.size() == kMaxFilters);
      for (const NlMeansFilter filter : {kSmallPatch, kLargePatch, kColorOnly, kMostlyFeatures})
        for (const auto& [px, py] : {std::pair{0, 0}, {6, 5}, {7, 6}, {20, 12}}) {
          double value = 0, self = 0;
          for (int h = 0; h < halves; ++h) {
            const Expected half = expected_result(input, filter, h, px, py);
            value += half.value / halves;
            self += half.self / halves;
          }
          CAPTURE(correlated);
          CAPTURE(halves);
          CAPTURE(filter);
          CHECK(filtered[filter].color[1].at(px, py) == doctest::Approx(value).epsilon(1e-4));
          CHECK(filtered[filter].self_weight.at(px, py) == doctest::Approx(self).epsilon(1e-3));
        }
    }
}

TEST_CASE("the noise correlation of pixels is measured from the half buffers and is zero for independent noise") {
  const NoiseCorrelation found = find_correlation(200, 150);
  const auto in_row = [](int dx) {
    return dx == 0 ? 1 : std::abs(dx) == 1 ? 2 / 3.0 : std::abs(dx) == 2 ? 1 / 6.0 : 0;
  };
  for (int dy = -3; dy <= 3; ++dy)
    for (int dx = -3; dx <= 3; ++dx) {
      CAPTURE(dx);
      CAPTURE(dy);
      const double expected = dy == 0 ? in_row(dx) : std::abs(dy) == 1 ? 0.5 * in_row(dx - dy) : 0;
      CHECK(std::abs(found(dx, dy) - expected) < 0.03);
    }
  CHECK(found(4, 0) == 0);
  const NlMeansInput white = noisy_input(200, 150, 2);
  const NoiseCorrelation none(white.half[0], white.half[1], white.variance);
  CHECK(none(0, 0) == 1);
  CHECK(std::abs(none(1, 0)) < 0.03);
  CHECK(none(-1, 1) == 0);
}

TEST_CASE("local planes preserve slopes that means would flatten") {
  // A noise-free slope with variances so large that all pixels look alike.
  NlMeansInput input = noisy_input(40, 30, 2);
  for (Planes3& half : input.half)
    for (Plane& plane : half) {
      for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) plane.at(x, y) = static_cast<float>(x + 2 * y);
      plane.extend();
    }
  for (Plane& plane : input.variance) {
    for (int y = 0; y < 30; ++y) std::fill_n(plane.row(y), 40, 1e6f);
    plane.extend();
  }
  input.features[0].scale = Plane(40, 30);  // the features do not distinguish pixels
  const std::vector<FilteredPlanes> filtered = nl_means(input, NlMeansSettings{4, 0.5f});
  for (const auto& [x, y] : {std::pair{20, 15}, {0, 15}, {39, 0}, {20, 29}})
    for (const NlMeansFilter filter : {kSmallPatch, kLargePatch})
      CHECK(filtered[filter].color[0].at(x, y) == doctest::Approx(x + 2 * y).epsilon(2e-2));
  CHECK(filtered[kColorOnly].color[0].at(20, 15) == doctest::Approx(50));
  CHECK(filtered[kColorOnly].color[0].at(0, 15) > 31);
}

TEST_CASE("local planes of few pixels neither remove all light nor amplify it") {
  NlMeansInput input = noisy_input(40, 30, 2);
  for (Planes3& half : input.half)
    for (Plane& plane : half) {
      for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) plane.at(x, y) = x < 8 ? 0.0f : static_cast<float>(sqr(x - 7));
      plane.extend();
    }
  for (Plane& plane : input.variance) {
    for (int y = 0; y < 30; ++y) std::fill_n(plane.row(y), 40, 1e9f);
    plane.extend();
  }
  input.features[0].scale = Plane(40, 30);
  const std::vector<FilteredPlanes> filtered = nl_means(input, NlMeansSettings{10, 0.5f});
  for (int x = 0; x < 40; ++x) {
    const float mean = filtered[kColorOnly].color[0].at(x, 15), plane = filtered[kLargePatch].color[0].at(x, 15);
    CAPTURE(x);
    CHECK(plane >= 0);
    CHECK(plane <= 2.0001f * mean);
  }
}

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
  CHECK(smooth[1].at(3, 4) == doctest::Approx(0.01));
  CHECK(smooth[1].at(4, 4) == doctest::Approx(0.3 * 9));
  CHECK(smooth[1].at(14, 4) == doctest::Approx((9 + 8 * 0.01) / 9));
  CHECK(smooth[1].at(0, 0) == doctest::Approx(0.01));
  CHECK(smooth_variance(variance, nullptr)[1].at(3, 4) == doctest::Approx((9 + 8 * 0.01) / 9));
}

TEST_CASE("NL-means has the same bits in registers as one pixel at a time") {
  const NlMeansInput input = noisy_input(37, 19, 2);
  const NlMeansSettings settings{3, 0.45f};
  std::vector<FilteredPlanes> wide = make_filtered_planes(input), scalar = make_filtered_planes(input);
  nl_means_tile<Wide>(input, settings, {0, 0, 37, 19}, wide);
  nl_means_tile<Scalar>(input, settings, {0, 0, 37, 19}, scalar);
  for (std::size_t filter = 0; filter < wide.size(); ++filter)
    for (std::size_t c = 0; c < 3; ++c)
      for (int y = 0; y < 19; ++y)
        CHECK(std::memcmp(wide[filter].color[c].row(y), scalar[filter].color[c].row(y), 37 * sizeof(float)) == 0);
}

TEST_CASE("features: vertical slopes are treated like horizontal ones") {
  // Inverse depth is linear on a plane; colours and normals are linear here too.
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
  const std::vector<Feature> features = features_of(across, down), turned = features_of(down, across);
  REQUIRE(features.size() == 3);
  for (int y = 1; y < kSide - 1; ++y)
    for (int x = 1; x < kSide - 1; ++x) {
      CHECK(features[2].slope_x.at(x, y) == doctest::Approx(across).epsilon(1e-3));
      CHECK(features[2].slope_y.at(x, y) == doctest::Approx(down).epsilon(1e-3));
      for (std::size_t i = 0; i < 3; ++i)
        CHECK(features[i].scale.at(x, y) == doctest::Approx(turned[i].scale.at(y, x)).epsilon(1e-3));
    }
  // Variation between pixels counts in both directions: three channels of 3 (across, down).
  CHECK(features[0].scale.at(5, 5) ==
        doctest::Approx(1 / (1.2 * 1.2 * 27 * double{across * across + down * down})).epsilon(1e-3));
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
  CHECK(down == doctest::Approx(across).epsilon(0.02));
  // Depth does not separate pixels on one plane.
  CHECK(down < sqr(0.2) / 50);
}

TEST_CASE("denoising reduces the error and features reduce it further and the mean is preserved") {
  constexpr int kColumns = 96, kRows = 64;
  double before = 0, errors[2][2];
  for (const bool halves : {false, true})
    for (const bool normals : {false, true}) {
      const Image noisy = noisy_picture(kColumns, kRows, halves, normals);
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
  CHECK(before == doctest::Approx(sqr(kNoise)).epsilon(0.1));
  CHECK(errors[0][0] < before / 5);
  CHECK(errors[1][0] < before / 8);
  CHECK(errors[1][1] < before / 20);
}

TEST_CASE("an edge below the noise level stays sharp where normals show it") {
  constexpr int kColumns = 96, kRows = 48;
  const Image with = denoise(noisy_picture(kColumns, kRows, true, true), Denoiser::kNlMeans).image;
  const Image without = denoise(noisy_picture(kColumns, kRows, true, false), Denoiser::kNlMeans).image;
  const double sharp = squared_error(with, "denoised.", kColumns / 2 - 2, kColumns / 2 + 2);
  CHECK(sharp < squared_error(without, "denoised.", kColumns / 2 - 2, kColumns / 2 + 2) / 2);
  CHECK(sharp < sqr(kNoise) / 10);
}

TEST_CASE("fireflies leave no blotches and features present in both halves survive") {
  constexpr int kSize = 48;
  const Image quiet = noisy_picture(kSize, kSize, true, false);
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
    CHECK(image.at(35, 30, out) == doctest::Approx(50).epsilon(0.02));
  }
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
  // The median of its neighbours replaces it.
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
    CHECK(mixed[1].at(3, y) == doctest::Approx(1));
    CHECK(mixed[1].at(kSize - 4, y) == doctest::Approx(color[1].at(kSize - 4, y)));
  }
}

TEST_CASE("denoising has the same bits on any number of threads and leaves other channels unchanged") {
  const Image noisy = noisy_picture(150, 50, true, true);
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
  const Image shown = denoised_only(one.image);
  CHECK(shown.channels == std::vector<std::string>{"R", "G", "B"});
  CHECK(shown.at(5, 5, 1) == one.image.at(5, 5, one.image.find_channel("denoised.G")));
}

TEST_CASE("denoising handles non-finite values and single pixels and missing variances") {
  Image noisy = noisy_picture(40, 20, true, true);
  noisy.at(10, 10, 0) = std::numeric_limits<float>::infinity();
  noisy.at(11, 10, 4) = std::numeric_limits<float>::quiet_NaN();
  noisy.at(12, 10, 8) = -std::numeric_limits<float>::infinity();
  const Image image = denoise(noisy, Denoiser::kNlMeans).image;
  for (int c = 0; c < 3; ++c) {
    const int out = image.find_channel(std::string("denoised.") + "RGB"[c]);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 40; ++x) CHECK(std::isfinite(image.at(x, y, out)));
  }
  const Image tiny = noisy_picture(1, 1, true, true);
  CHECK(denoise(tiny, Denoiser::kNlMeans).image.at(0, 0, tiny.find_channel("R")) == tiny.at(0, 0, 0));
  const Image bare(4, 4, {"R", "G", "B"});
  CHECK_THROWS_WITH_AS(denoise(bare, Denoiser::kNlMeans), doctest::Contains("--replicates"), Error);
}

}  // namespace sheaf::test_nl_means

// Non-local means against their definition, local planes, and the noise correlation of pixels.
#include "kernels/denoise/nl_means.h"
#include "kernels/denoise/noise_correlation.h"
#include "tests/kernels/denoise/noisy_images.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace sheaf::test_nl_means {

using namespace noisy_images;

namespace {

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
  if (filter == kFeatureFilter)
    most = std::max(0.0, 0.1 * (in.halves == 2 ? (distance(0) + distance(1)) / 2 : distance(0)));
  if (filter != kColorOnly) most = std::max(most, feature);
  return std::pow(std::max(1 - most / 16, 0.0), 16);
}

/// Filtered value of a pixel in one half, and the correlation of its noise with that of the pixel itself.
struct Expected {
  double value, self;
};

/// By the definition: the weighted mean, or the weighted least-squares plane, whose slopes are regularized by 3 pixels
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
  if (filter == kColorOnly || filter == kFeatureFilter) m[0][1] = m[0][2] = m[1][0] = m[2][0] = 0;
  for (int i = 0; i < 3; ++i)
    for (int row = 0; row < 3; ++row) {
      if (row == i) continue;
      const double factor = m[row][i] / m[i][i];
      for (int j = 0; j < 4; ++j) m[row][j] -= factor * m[i][j];
    }
  Expected expected{0, 0};
  for (const Pixel& q : pixels) {
    const double fraction = q.weight * (m[0][3] / m[0][0] + q.dx * m[1][3] / m[1][1] + q.dy * m[2][3] / m[2][2]);
    expected.value += fraction * q.value;
    expected.self += fraction * q.correlation;
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
      for (const NlMeansFilter filter : {kSmallPatch, kLargePatch, kColorOnly, kFeatureFilter})
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
          CHECK(filtered[filter].color[1].at(px, py) == near(value, 1e-4));
          CHECK(filtered[filter].self_weight.at(px, py) == near(self, 1e-3));
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
      CHECK(filtered[filter].color[0].at(x, y) == near(x + 2 * y, 2e-2));
  CHECK(filtered[kColorOnly].color[0].at(20, 15) == near(50));
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

}  // namespace sheaf::test_nl_means

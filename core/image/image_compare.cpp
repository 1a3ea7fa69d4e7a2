// Sums over pixels, error metrics and the Z-test.
#include "core/image/image_compare.h"

#include "core/io/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// The overlap of two images in frame coordinates; x1 and y1 are exclusive.
struct Overlap {
  int x0, y0, x1, y1;
};

Overlap find_overlap(const Image& a, const Image& b) {
  if (a.frame_width != b.frame_width || a.frame_height != b.frame_height) {
    throw Error(ExitCode::kUsage, fmt::format("the images differ in size: {} x {} and {} x {}", a.frame_width,
                                              a.frame_height, b.frame_width, b.frame_height));
  }
  const Overlap overlap{std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x0 + a.width, b.x0 + b.width),
                        std::min(a.y0 + a.height, b.y0 + b.height)};
  if (overlap.x0 >= overlap.x1 || overlap.y0 >= overlap.y1) {
    throw Error(ExitCode::kUsage, "the images' crop windows do not overlap");
  }
  return overlap;
}

/// One channel of an image, in frame coordinates.
class ChannelView {
 public:
  ChannelView(const Image& image, const std::string& channel, const char* role)
      : image_(image), channel_(image.find_channel(channel)) {
    if (channel_ < 0) throw Error(ExitCode::kUsage, fmt::format("{} has no channel '{}'", role, channel));
  }
  double operator()(int x, int y) const {
    return static_cast<double>(image_.at(x - image_.x0, y - image_.y0, channel_));
  }

 private:
  const Image& image_;
  int channel_;
};

/// Two-sided p-value of a standard normal variable.
double p_value(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

double z_value(double difference, double variance, double magnitude) {
  if (variance > 0) return difference / std::sqrt(variance);
  return std::abs(difference) <= 1e-5 * magnitude ? 0.0 : std::copysign(1e9, difference);
}

/// Sums over one channel. add() adds another channel, without its variance.
struct Sums {
  double squares = 0, relative = 0, a = 0, b = 0, variance = 0, z_squared = 0;
  std::size_t values = 0, accepted = 0, non_finite = 0;

  void add(const Sums& s) {
    squares += s.squares;
    relative += s.relative;
    a += s.a;
    b += s.b;
    z_squared += s.z_squared;
    values += s.values;
    accepted += s.accepted;
    non_finite += s.non_finite;
  }
};

struct Pair {
  const Image &a, &b;
  const CompareOptions& options;
};

Sums sum_channel(const Pair& pair, const std::string& channel, const Overlap& overlap) {
  const ChannelView a(pair.a, channel, "the first image"), b(pair.b, channel, "the second image");
  std::optional<ChannelView> variance_a, variance_b;
  if (pair.options.variance_a) variance_a.emplace(*pair.options.variance_a, channel, "the first image's variance");
  if (pair.options.variance_b) variance_b.emplace(*pair.options.variance_b, channel, "the second image's variance");
  // Add up errors and z-tests over the pixels
  Sums sums;
  for (int y = overlap.y0; y < overlap.y1; ++y) {
    for (int x = overlap.x0; x < overlap.x1; ++x) {
      const double va = a(x, y), vb = b(x, y);
      const double variance = (variance_a ? (*variance_a)(x, y) : 0.0) + (variance_b ? (*variance_b)(x, y) : 0.0);
      if (!std::isfinite(va) || !std::isfinite(vb) || !std::isfinite(variance)) {
        ++sums.non_finite;
        continue;
      }
      const double difference = va - vb, z = z_value(difference, variance, std::max(std::abs(va), std::abs(vb)));
      ++sums.values;
      sums.squares += difference * difference;
      sums.relative += difference * difference / (vb * vb + 0.01);
      sums.a += va;
      sums.b += vb;
      sums.variance += std::max(variance, 0.0);
      sums.z_squared += z * z;
      if (p_value(z) >= pair.options.significance) ++sums.accepted;
    }
  }
  return sums;
}

void require_cover(const std::optional<Image>& variance, const Image& image, const char* role) {
  if (!variance) return;
  const bool same = variance->x0 == image.x0 && variance->y0 == image.y0 && variance->width == image.width &&
                    variance->height == image.height;
  if (!same) throw Error(ExitCode::kUsage, fmt::format("{} image and its variance differ in size or crop", role));
}

}  // namespace

double ZTest::accepted_fraction() const {
  return tests == 0 ? 1.0 : static_cast<double>(accepted) / static_cast<double>(tests);
}

double ZTest::corrected_mean_p() const {
  double smallest = 1;
  for (const double p : mean_p) smallest = std::min(smallest, p * static_cast<double>(mean_p.size()));
  return smallest;
}

std::optional<Image> variance_layers(const Image& image) {
  const int red = image.find_channel("variance.R"), green = image.find_channel("variance.G"),
            blue = image.find_channel("variance.B");
  if (red < 0 || green < 0 || blue < 0) return std::nullopt;
  Image variance(image.width, image.height, {"R", "G", "B"});
  variance.x0 = image.x0;
  variance.y0 = image.y0;
  variance.frame_width = image.frame_width;
  variance.frame_height = image.frame_height;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      variance.at(x, y, 0) = image.at(x, y, red);
      variance.at(x, y, 1) = image.at(x, y, green);
      variance.at(x, y, 2) = image.at(x, y, blue);
    }
  }
  return variance;
}

ImageComparison compare_images(const Image& a, const Image& b, const CompareOptions& options) {
  // Find the pixels and channels to compare
  const Overlap overlap = find_overlap(a, b);
  require_cover(options.variance_a, a, "the first");
  require_cover(options.variance_b, b, "the second");
  const bool gray = a.find_channel("R") < 0 && b.find_channel("R") < 0 && a.find_channel("Y") >= 0;
  ImageComparison result;
  result.channels = gray ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
  result.width = overlap.x1 - overlap.x0;
  result.height = overlap.y1 - overlap.y0;
  // Compare channel by channel
  ZTest test;
  test.significance = options.significance;
  Sums all;
  for (const std::string& channel : result.channels) {
    const Sums sums = sum_channel({a, b, options}, channel, overlap);
    const double magnitude = std::max(std::abs(sums.a), std::abs(sums.b));
    test.mean_p.push_back(p_value(z_value(sums.a - sums.b, sums.variance, magnitude)));
    all.add(sums);
  }
  // Average over pixels and channels
  const double count = std::max(static_cast<double>(all.values), 1.0);
  result.mse = all.squares / count;
  result.relative_mse = all.relative / count;
  result.mean_a = all.a / count;
  result.mean_b = all.b / count;
  result.mean_ratio = all.a == all.b ? 1.0 : all.a / all.b;
  result.non_finite = all.non_finite;
  if (options.variance_a || options.variance_b) {
    test.tests = all.values;
    test.accepted = all.accepted;
    test.mean_z_squared = all.z_squared / count;
    result.z_test = test;
  }
  return result;
}

}  // namespace sheaf

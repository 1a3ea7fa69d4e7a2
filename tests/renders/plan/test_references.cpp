// Renders the scenes of tests/references/scenes and both versions of the Cornell box, and compares them with references
// of another renderer (tests/references/make_references.py). Moving scenes, tests/references/pbrt, are compared with
// references of pbrt-v4 (tests/references/make_pbrt_references.py). The expected noise is taken from the variances of
// the reference. Where independently seeded batches vary more, because lights are selected differently, the larger
// variance is used, up to a limit.
#include "core/image/exr.h"
#include "core/image/image_compare.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/dialects/read_scene.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace sheaf::test_references {

namespace fs = std::filesystem;

namespace {

const fs::path kFolder = fs::path(SHEAF_SOURCE_DIR) / "tests" / "references";
const fs::path kCornell = fs::path(SHEAF_SOURCE_DIR) / "scenes" / "cornell";
const std::vector<std::string> kRgb{"R", "G", "B"};

constexpr int kBatchSamples = 96;
constexpr int kBatches = 10;
/// Side of the pixel blocks whose means are compared in addition to single pixels.
constexpr int kBlock = 8;
/// Differences below this standard deviation are rounding errors: absolute, and relative to the reference.
constexpr double kFloor = 1e-4, kRelativeFloor = 1e-3;
/// Fraction of pixel values that must be accepted. Pixel means with outliers among their samples are not exactly
/// normal.
constexpr double kAcceptedFraction = 0.9975;
/// Allowed relative difference of the means of the two renderers, and allowed standard deviations of noise. Both are
/// independent errors and add in quadrature.
constexpr double kMeanFloor = 0.002, kMeanSigmas = 4;
/// Largest ratio between the variance of batches and that of the reference.
constexpr double kMaxVarianceRatio = 4;

/// An image with its noise.
struct Estimate {
  Image mean;          ///< R, G, B
  Image variance;      ///< of one sample
  double samples = 0;  ///< per pixel
};

/// Means over squares of `side` pixels. Incomplete squares at the right and lower edge are averaged over their pixels.
Image block_means(const Image& image, int side) {
  Image out((image.width + side - 1) / side, (image.height + side - 1) / side, kRgb);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const int x1 = std::min(image.width, (x + 1) * side), y1 = std::min(image.height, (y + 1) * side);
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int v = y * side; v < y1; ++v)
          for (int u = x * side; u < x1; ++u) sum += image.at(u, v, image.find_channel(kRgb[static_cast<size_t>(c)]));
        out.at(x, y, c) = static_cast<float>(sum / ((x1 - x * side) * (y1 - y * side)));
      }
    }
  return out;
}

/// Reads a reference, including its sample count.
Estimate read_reference(const std::string& name) {
  Estimate e{block_means(read_exr(kFolder / (name + ".exr")), 1),
             block_means(read_exr(kFolder / (name + "_var.exr")), 1)};
  for (const auto& attribute : read_exr_attributes(kFolder / (name + ".exr")))
    if (attribute.name == "samples") e.samples = std::stod(std::get<std::string>(attribute.value));
  REQUIRE(e.samples > 0);
  return e;
}

/// Renders batches with seeds 1, 2, ... and averages squares of `side` pixels. The variance is that between batches.
Estimate render_batches(const fs::path& file, int batches, int batch_samples, int side,
                        ColorMode color = ColorMode::kRgb) {
  Description description = read_scene(file);
  // Sets the roulette depth of the references where scenes leave it open, because other settings change the variance.
  IntegratorSettings& integrator = description.integrator;
  if (!integrator.rr_depth) integrator.rr_depth = kDefaultRouletteDepth;
  const auto scene = compile_scene(description, {false, color});
  std::vector<Image> images;
  for (int i = 0; i < batches; ++i) {
    RenderOptions options;
    options.samples_per_pixel = static_cast<std::uint32_t>(batch_samples);
    options.seed = static_cast<std::uint32_t>(i + 1);
    images.push_back(block_means(render(*scene, options).film.to_image(), side));
  }
  Estimate e{images[0], images[0], double(batches) * batch_samples * side * side};
  for (std::size_t i = 0; i < images[0].data.size(); ++i) {
    MeanVariance statistics;
    for (const Image& image : images) statistics.add(image.data[i]);
    e.mean.data[i] = static_cast<float>(statistics.mean());
    e.variance.data[i] = static_cast<float>(statistics.variance() * e.samples / batches);
  }
  return e;
}

double mean_of(const Image& image, int channel) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += image.at(x, y, channel);
  return sum / static_cast<double>(image.pixel_count());
}

/// Agreement of an image with its reference.
struct Verdict {
  double pixel_fraction = 0;        ///< fraction of pixel values that the Z-test accepts
  double block_fraction = 0;        ///< fraction of block means that the Z-test accepts
  double worst_mean_error = 0;      ///< largest deviation of a channel's mean over the allowed one
  double worst_variance_ratio = 0;  ///< largest ratio of a channel's variance to the reference's
  bool agrees() const { return pixel_fraction >= kAcceptedFraction && block_fraction == 1 && worst_mean_error <= 1; }
};

/// Variance of the difference of two means: that of the reference, or that of the image where its blocks vary more.
Image difference_variance(const Estimate& estimate, const Estimate& reference) {
  const Image own = block_means(estimate.variance, kBlock), theirs = block_means(reference.variance, kBlock);
  Image out = reference.variance;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double floor = kFloor + kRelativeFloor * std::fabs(reference.mean.at(x, y, c));
        const double block = theirs.at(x / kBlock, y / kBlock, c);
        const double excess = std::max(0.0, own.at(x / kBlock, y / kBlock, c) - block);
        const double of_sample = reference.variance.at(x, y, c);
        out.at(x, y, c) =
            static_cast<float>((of_sample + excess) / estimate.samples + of_sample / reference.samples + floor * floor);
      }
  return out;
}

/// Fraction of the values that the Z-test accepts at the joint significance level `significance`.
double accepted_fraction(const Image& estimate, const Image& reference, const Image& variance, double significance) {
  CompareOptions options;
  options.variance_b = variance;
  options.significance = significance_of_each(3 * static_cast<int>(estimate.pixel_count()), significance);
  return compare_images(estimate, reference, options).z_test->accepted_fraction();
}

Verdict judge(const Estimate& estimate, const Estimate& reference) {
  REQUIRE(estimate.mean.width == reference.mean.width);
  REQUIRE(estimate.mean.height == reference.mean.height);
  const Image variance = difference_variance(estimate, reference);
  Verdict v;
  v.pixel_fraction = accepted_fraction(estimate.mean, reference.mean, variance, 0.01);
  Image block_variance = block_means(variance, kBlock);
  for (int y = 0; y < block_variance.height; ++y)
    for (int x = 0; x < block_variance.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const int width = std::min(kBlock, variance.width - x * kBlock);
        const int height = std::min(kBlock, variance.height - y * kBlock);
        block_variance.at(x, y, c) /= static_cast<float>(width * height);
      }
  v.block_fraction = accepted_fraction(block_means(estimate.mean, kBlock), block_means(reference.mean, kBlock),
                                       block_variance, kSignificance);
  for (int c = 0; c < 3; ++c) {
    const double expected = mean_of(reference.mean, c);
    const double sigma = std::sqrt(mean_of(variance, c) / static_cast<double>(variance.pixel_count()));
    const double allowed = std::hypot(kMeanFloor * expected, kMeanSigmas * sigma);
    v.worst_mean_error = std::max(v.worst_mean_error, std::fabs(mean_of(estimate.mean, c) - expected) / allowed);
    const double least = kFloor * kFloor;
    v.worst_variance_ratio = std::max(
        v.worst_variance_ratio, (mean_of(estimate.variance, c) + least) / (mean_of(reference.variance, c) + least));
  }
  return v;
}

void check(const std::string& name, const Estimate& estimate, const Estimate& reference) {
  const Verdict v = judge(estimate, reference);
  INFO(name << ": mean " << mean_of(estimate.mean, 0) << " " << mean_of(estimate.mean, 1) << " "
            << mean_of(estimate.mean, 2) << ", expected " << mean_of(reference.mean, 0) << " "
            << mean_of(reference.mean, 1) << " " << mean_of(reference.mean, 2));
  CHECK(v.pixel_fraction >= kAcceptedFraction);
  CHECK(v.block_fraction == 1);
  CHECK(v.worst_mean_error <= 1);
  CHECK(v.worst_variance_ratio <= kMaxVarianceRatio);
}

/// The names of the scenes in a folder, without the extension.
std::vector<std::string> scene_names(const std::string& folder = "scenes", const std::string& extension = ".xml") {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(kFolder / folder))
    if (entry.path().extension() == extension && entry.path().stem().string()[0] != '.')
      names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

TEST_SUITE("slow") {
  TEST_CASE("every scene agrees with its reference") {
    const auto names = scene_names();
    REQUIRE(names.size() > 40);
    for (const std::string& name : names) {
      try {
        check(name, render_batches(kFolder / "scenes" / (name + ".xml"), kBatches, kBatchSamples, 1),
              read_reference(name));
      } catch (const Error& error) { FAIL_CHECK(name << ": " << error.what()); }
    }
  }

  TEST_CASE("spectral mode agrees with references of another spectral renderer") {
    const std::string suffix = "_spectral";
    int found = 0;
    for (const std::string& name : scene_names()) {
      if (!fs::exists(kFolder / (name + suffix + ".exr"))) continue;
      ++found;
      const fs::path file = kFolder / "scenes" / (name + ".xml");
      check(name + suffix, render_batches(file, kBatches, kBatchSamples, 1, ColorMode::kSpectral),
            read_reference(name + suffix));
    }
    CHECK(found == 10);
  }

  TEST_CASE("moving scenes agree with references of a third renderer") {
    const auto names = scene_names("pbrt", ".pbrt");
    CHECK(names.size() == 3);
    for (const std::string& name : names)
      check(name, render_batches(kFolder / "pbrt" / (name + ".pbrt"), kBatches, kBatchSamples, 1),
            read_reference(name));
  }

  TEST_CASE("the Cornell box agrees with its reference in both dialects") {
    const Estimate reference = read_reference("cornell");
    for (const char* name : {"cornell", "cornell_nori"}) {
      const fs::path file = kCornell / (std::string(name) + ".xml");
      const int side = read_scene(file).film.width / reference.mean.width;
      check(name, render_batches(file, 4, 1, side), reference);
    }
  }

  TEST_CASE("the comparison notices small errors") {
    const Estimate reference = read_reference("direct_area");
    Estimate estimate = render_batches(kFolder / "scenes" / "direct_area.xml", kBatches, kBatchSamples, 1);
    REQUIRE(judge(estimate, reference).agrees());
    Estimate brighter = estimate, shifted = estimate, patched = estimate;
    for (float& value : brighter.mean.data) value *= 1.01f;
    CHECK(judge(brighter, reference).worst_mean_error > 1);
    for (int y = 0; y < shifted.mean.height; ++y)
      for (int x = shifted.mean.width - 1; x > 0; --x)
        for (int c = 0; c < 3; ++c) shifted.mean.at(x, y, c) = shifted.mean.at(x - 1, y, c);
    CHECK(judge(shifted, reference).pixel_fraction < kAcceptedFraction);
    for (int y = 24; y < 32; ++y)
      for (int x = 24; x < 32; ++x)
        for (int c = 0; c < 3; ++c) patched.mean.at(x, y, c) *= 1.04f;
    CHECK(judge(patched, reference).block_fraction < 1);
  }
}

}  // namespace sheaf::test_references

// Comparison of two renderings of a scene: error metrics, and a Z-test of whether noise explains the difference.
#pragma once

#include "core/image/image.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// The Z-test: differences in units of the standard deviation of the noise. Each value of each channel is one test.
struct ZTest {
  double significance = 0.01;  ///< level of each single test
  std::size_t tests = 0;
  std::size_t accepted = 0;    ///< tests whose p-value is at least the significance
  double mean_z_squared = 0;   ///< 1 if the variances are right and the expectations equal
  std::vector<double> mean_p;  ///< per channel: p-value of the test that the images' means are equal
  /// Fraction of tests accepted, in [0, 1]; pure noise gives 1 - significance. 1 without tests.
  double accepted_fraction() const;
  /// The smallest of mean_p after the Bonferroni correction, at most 1. 1 without channels.
  double corrected_mean_p() const;
};

/// Figures over all values of the compared channels, in linear units. B is the reference.
struct ImageComparison {
  std::vector<std::string> channels;
  int width = 0, height = 0;  ///< pixels that both images have
  double mse = 0;             ///< mean of (a - b)^2
  double relative_mse = 0;    ///< mean of (a - b)^2 / (b^2 + 0.01) (Rousselle et al. 2011)
  double mean_a = 0, mean_b = 0;
  double mean_ratio = 1;        ///< mean_a / mean_b; 1 if both are 0
  std::size_t non_finite = 0;   ///< values left out because they are NaN or infinite in one image
  std::optional<ZTest> z_test;  ///< if a variance was given
};

/// Variances of the pixel means, in the channels R, G and B, with the same windows as the images.
struct CompareOptions {
  std::optional<Image> variance_a, variance_b;
  double significance = 0.01;  ///< of each single Z-test; in (0, 1)
};

/// The variance.R, variance.G and variance.B layers as an image with the channels R, G, B; nothing if one is missing.
std::optional<Image> variance_layers(const Image& image);

/// Compares the channels R, G and B, or Y if neither image has R. Different crops of the same frame are compared where
/// they overlap. An image without variance counts as free of noise. Throws Error (exit code 2) if the frames differ in
/// size, the crops do not overlap, a channel is missing, or a variance has another window than its image.
ImageComparison compare_images(const Image& a, const Image& b, const CompareOptions& options = {});

}  // namespace sheaf

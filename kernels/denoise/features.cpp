#include "kernels/denoise/features.h"

#include "kernels/denoise/smooth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Feature difference with distance 1, in units of the larger of the change from pixel to pixel and a minimum
/// difference.
constexpr float kFeatureK = 1.2f;
/// Minimum squared differences: of colors and directions, and of depth relative to depth.
constexpr float kMinSquare = 2e-3f, kMinDepthSquare = 1e-3f;
/// Filter settings for denoising the features.
constexpr NlMeansSettings kPrefilter{5, 1.0f};
/// Values with a larger magnitude count as invalid.
constexpr float kMax = 1e15f;

/// The smaller of the changes to both neighbors, which ignores discontinuities.
float gentle_slope(float before, float here, float after) {
  const float a = here - before, b = after - here;
  return std::abs(a) < std::abs(b) ? a : b;
}

/// Change of a plane per step of (dx, dy), with an extended border.
Plane slope_of(const Plane& plane, int dx, int dy) {
  Plane slope(plane.width(), plane.height());
  tbb::parallel_for(0, plane.height(), [&](int y) {
    for (int x = 0; x < plane.width(); ++x)
      slope.at(x, y) = gentle_slope(plane.at(x - dx, y - dy), plane.at(x, y), plane.at(x + dx, y + dy));
  });
  slope.extend();
  return slope;
}

/// Smoothed variances of channels; empty if the image has none.
std::vector<Plane> find_variances(const Image& image, std::vector<std::string> names) {
  for (std::string& name : names) name.insert(0, "variance.");
  std::vector<Plane> planes = find_planes(image, names);
  for (Plane& plane : planes) plane = box_mean(plane, 2);
  return planes;
}

/// Denoises a feature of three channels. Its residual variance is assumed to be zero.
void prefilter(std::vector<Plane>& channels, std::vector<Plane> variances, const NoiseCorrelation& correlation) {
  NlMeansInput input;
  input.width = channels[0].width();
  input.height = channels[0].height();
  input.epsilon = 1e-6f;
  input.correlation = correlation;
  for (std::size_t c = 0; c < 3; ++c) {
    input.half[0][c] = std::move(channels[c]);
    input.variance[c] = std::move(variances[c]);
  }
  std::vector<FilteredPlanes> filtered = nl_means(input, kPrefilter);
  for (std::size_t c = 0; c < 3; ++c) {
    channels[c] = std::move(filtered[kLargePatch].color[c]);
    channels[c].extend();
  }
}

/// Feature of colors or directions. Its scale includes the local change from pixel to pixel.
Feature make_feature(std::vector<Plane> channels) {
  Feature feature;
  const int width = channels[0].width(), height = channels[0].height();
  feature.scale = Plane(width, height);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      float square = 0;
      for (const Plane& plane : channels) {
        const float here = plane.at(x, y);
        square += sqr(gentle_slope(plane.at(x - 1, y), here, plane.at(x + 1, y))) +
                  sqr(gentle_slope(plane.at(x, y - 1), here, plane.at(x, y + 1)));
      }
      feature.scale.at(x, y) = 1 / (sqr(kFeatureK) * std::max(square, kMinSquare));
    }
  });
  feature.channels = std::move(channels);
  return feature;
}

/// Depth feature, stored as inverse depth, which is linear in image space across a plane in the scene. Therefore only
/// deviations from the plane through a pixel and its neighbors count. Inverse depth is 0 where nothing is hit.
Feature make_depth_feature(const Plane& depth) {
  const int width = depth.width(), height = depth.height();
  // Invert the depth
  Plane inverse(width, height);
  double sum = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float z = depth.at(x, y);
      inverse.at(x, y) = z > 0 ? 1 / z : 0.0f;
      sum += inverse.at(x, y);
    }
  inverse.extend();
  Feature feature;
  feature.scale = Plane(width, height);
  // Estimate the slope, and scale differences relative to the depth
  feature.slope_x = slope_of(inverse, 1, 0);
  feature.slope_y = slope_of(inverse, 0, 1);
  const float smallest = 0.1f * static_cast<float>(sum / (static_cast<double>(width) * height)) + 1e-12f;
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x)
      feature.scale.at(x, y) = 1 / (sqr(kFeatureK) * kMinDepthSquare * sqr(std::max(inverse.at(x, y), smallest)));
  });
  feature.channels.push_back(std::move(inverse));
  return feature;
}

}  // namespace

std::vector<Plane> find_planes(const Image& image, const std::vector<std::string>& names) {
  std::vector<Plane> planes;
  for (const std::string& name : names) {
    const int c = image.find_channel(name);
    if (c < 0) return {};
    Plane& plane = planes.emplace_back(image.width, image.height);
    tbb::parallel_for(0, image.height, [&](int y) {
      for (int x = 0; x < image.width; ++x) {
        const float value = image.at(x, y, c);
        plane.at(x, y) = std::abs(value) <= kMax ? value : 0.0f;
      }
    });
    plane.extend();
  }
  return planes;
}

std::vector<Feature> find_features(const Image& image, const NoiseCorrelation& correlation) {
  std::vector<Feature> features;
  for (const auto& names : {std::vector<std::string>{"albedo.R", "albedo.G", "albedo.B"}, {"N.X", "N.Y", "N.Z"}}) {
    std::vector<Plane> channels = find_planes(image, names);
    if (channels.empty()) continue;
    if (std::vector<Plane> variances = find_variances(image, names); !variances.empty())
      prefilter(channels, std::move(variances), correlation);
    features.push_back(make_feature(std::move(channels)));
  }
  if (const std::vector<Plane> depth = find_planes(image, {"Z"}); !depth.empty())
    features.push_back(make_depth_feature(depth[0]));
  return features;
}

}  // namespace sheaf

// Daylight (Hosek and Wilkie 2012, 2013).
//
// Hosek and Wilkie 2012, equation 8: with the angle theta to the zenith and gamma to the sun, a channel's radiance is
// R (1 + A e^(B / (cos theta + 0.01))) (C + D e^(E gamma) + F cos^2 gamma + G chi(H, gamma) + I sqrt(cos theta)),
// chi(g, gamma) = (1 + cos^2 gamma) / (1 + g^2 - 2 g cos gamma)^(3/2).
// R and A to I are quintic Bezier curves over the cube root of the sun's elevation (equation 11), linear in turbidity
// and albedo. In the tables, H comes last. Hosek and Wilkie 2013: the radiance at the sun's center is a piecewise cubic
// of its elevation, with pieces of equal length in the cube root. It is multiplied by a polynomial of the cosine at the
// sun's surface for limb darkening, whose average over the disk is used here.
#include "scene/lights/daylight.h"

#include "core/color/color.h"
#include "core/math/frame.h"
#include "scene/data/daylight.h"
#include "scene/lights/sun_light.h"
#include "scene/spectra/spectrum_rgb.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace sheaf {

namespace {

namespace data = daylight_data;

constexpr double kPiD = std::numbers::pi;
constexpr double kFirstWavelength = 320, kWavelengthStep = 40;
/// Maximum number of skies that are averaged.
constexpr std::size_t kMaxSkies = 256;

/// Interpolation between tables of turbidity: index of the lower table, and weight of the upper one.
struct TurbidityInterpolation {
  std::size_t below;
  double above;
  explicit TurbidityInterpolation(float turbidity) {
    const double interpolation = std::clamp(double(turbidity), 1.0, double(data::kTurbidities)) - 1;
    below = std::min(static_cast<std::size_t>(interpolation), data::kTurbidities - 2);
    above = interpolation - static_cast<double>(below);
  }
  /// Interpolates entry `i` of tables with `size` entries.
  double mix(std::span<const float> tables, std::size_t size, std::size_t i) const {
    return (1 - above) * double(tables[below * size + i]) + above * double(tables[(below + 1) * size + i]);
  }
};

/// Evaluates entry `i` of a Bezier curve whose control points have `size` entries.
double bezier(std::span<const float> tables, const TurbidityInterpolation& turbidity, double albedo, double x,
              std::size_t size, std::size_t i) {
  constexpr double kBinomial[data::kControlPoints] = {1, 5, 10, 10, 5, 1};
  const std::size_t of_albedo = data::kControlPoints * size;
  double sum = 0;
  for (std::size_t k = 0; k < data::kControlPoints; ++k) {
    const double black = turbidity.mix(tables, 2 * of_albedo, k * size + i);
    const double white = turbidity.mix(tables, 2 * of_albedo, of_albedo + k * size + i);
    const double weight = kBinomial[k] * std::pow(x, double(k)) * std::pow(1 - x, double(5 - k));
    sum += weight * ((1 - albedo) * black + albedo * white);
  }
  return sum;
}

/// Skies for up to kMaxSkies of the suns, without suns below the horizon, and one over the number of suns considered.
struct Skies {
  struct Sky {
    Vec3f sun;
    SkyModel model;
  };
  std::vector<Sky> all;
  double sun_weight = 0;

  explicit Skies(const SkyDescription& sky) {
    const std::size_t stride = (sky.suns.size() + kMaxSkies - 1) / kMaxSkies;
    std::size_t count = 0;
    for (std::size_t i = 0; i < sky.suns.size(); i += stride, ++count) {
      const double height = dot(sky.suns[i], sky.up);
      if (!(height >= 0.0)) continue;
      all.push_back(
          {sky.suns[i], SkyModel(sky.turbidity, reflectance_rgb(sky.albedo), std::asin(std::min(height, 1.0)))});
    }
    sun_weight = count > 0 ? 1.0 / static_cast<double>(count) : 0;
  }

  /// Radiance from a unit direction, with cosine `cos_zenith` to the zenith.
  std::array<double, 3> radiance(Vec3f direction, double cos_zenith) const {
    std::array<double, 3> sum{};
    for (const Sky& sky : all) {
      const double to_sun = 2 * std::asin(std::min(0.5 * double(length(direction - sky.sun)), 1.0));
      const auto one = sky.model.radiance(cos_zenith, to_sun);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += sun_weight * one[c];
    }
    return sum;
  }
};

/// Adds each sun to the four nodes around it.
void add_suns(const SkyDescription& sky, const Frame<Scalar>& frame, EnvmapImage& image) {
  const double half = std::sin(0.5 * double(SunDescription::kSunRadius) * (kPiD / 180));
  const double solid_angle = 4 * kPiD * half * half;
  const double sun_weight = double(sky.sun_scale) * solid_angle / static_cast<double>(sky.suns.size());
  for (const Vec3f sun : sky.suns) {
    // Compute the color of the sun at its elevation
    const double height = dot(sun, sky.up);
    if (!(height >= 0.0)) continue;
    const Vec3f rgb = sun_rgb(sun_spectrum(sky.turbidity, std::asin(std::min(height, 1.0))));
    // Find its position between nodes
    const Vec3f at = frame.to_local(stretched(sun, sky.up, sky.stretch));
    const double azimuth = std::atan2(double(at.x), -double(at.z)) / (2 * kPiD);
    const double across = (azimuth - std::floor(azimuth)) * image.width - 0.5;
    const double down = std::acos(std::clamp(double(at.y), -1.0, 1.0)) / kPiD * (image.height - 1);
    const double column = std::floor(across), row = std::min(std::floor(down), image.height - 2.0);
    // Distribute its power bilinearly over the four nodes
    for (int k = 0; k < 4; ++k) {
      const int right = k % 2, below = k / 2;
      const double x = column + right, y = row + below;
      const double weight = (1 - std::fabs(across - x)) * (1 - std::fabs(down - y));
      const auto j = static_cast<std::uint32_t>(y);
      const auto i = static_cast<std::uint32_t>(x + image.width) % image.width;
      const double scale = sun_weight * weight / node_solid_angle(j, image.width, image.height);
      float* node = &image.rgb[3 * (std::size_t{j} * image.width + i)];
      node[0] += static_cast<float>(scale * double(rgb.x));
      node[1] += static_cast<float>(scale * double(rgb.y));
      node[2] += static_cast<float>(scale * double(rgb.z));
    }
  }
}

}  // namespace

SkyModel::SkyModel(float turbidity, Vec3f albedo, double elevation) {
  const TurbidityInterpolation interpolation(turbidity);
  const double x = std::cbrt(std::clamp(elevation / (0.5 * kPiD), 0.0, 1.0));
  const float albedos[3] = {albedo.x, albedo.y, albedo.z};
  // The tables are integrals over the spectrum; RGB mode divides these by the integral of the y curve.
  constexpr double kUnits = 106.7502593994140625;
  for (std::size_t c = 0; c < 3; ++c) {
    const double ground = std::clamp(double(albedos[c]), 0.0, 1.0);
    for (std::size_t k = 0; k < 9; ++k)
      shape_[c][k] =
          bezier(data::sky_shape(), interpolation, ground, x, 3 * data::kSkyParameters, data::kSkyParameters * c + k);
    radiance_[c] = bezier(data::sky_radiance(), interpolation, ground, x, 3, c) / kUnits;
  }
}

std::array<double, 3> SkyModel::radiance(double cos_zenith, double to_sun) const {
  const double cosine = std::cos(to_sun), squared = cosine * cosine;
  const double root = std::sqrt(std::max(cos_zenith, 0.0));
  std::array<double, 3> out;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& [a, b, c0, d, e, f, g, i, h] = shape_[c];
    const double base = 1 + h * h - 2 * h * cosine;
    const double chi = (1 + squared) / (base * std::sqrt(base));
    out[c] = radiance_[c] * (1 + a * std::exp(b / (cos_zenith + 0.01))) *
             (c0 + d * std::exp(e * to_sun) + f * squared + g * chi + i * root);
  }
  return out;
}

SpectrumDescription::Table sun_spectrum(float turbidity, double elevation) {
  const TurbidityInterpolation interpolation(turbidity);
  const double pieces = double(data::kSunPieces);
  const double at = std::cbrt(std::clamp(elevation / (0.5 * kPiD), 0.0, 1.0)) * pieces;
  const std::size_t piece = std::min(static_cast<std::size_t>(at), data::kSunPieces - 1);
  const double above = elevation - 0.5 * kPiD * std::pow(double(piece) / pieces, 3);
  SpectrumDescription::Table table;
  for (std::size_t k = 0; k < data::kSunWavelengths; ++k) {
    double center = 0, limb = 0;
    for (std::size_t n = data::kSunOrder; n-- > 0;)
      center = center * above + interpolation.mix(data::sun_radiance(),
                                                  data::kSunPieces * data::kSunWavelengths * data::kSunOrder,
                                                  (piece * data::kSunWavelengths + k) * data::kSunOrder + n);
    // The average of the n-th power of the cosine over the disk is 2 / (n + 2).
    for (std::size_t n = 0; n < data::kLimbOrder; ++n)
      limb += double(data::limb_darkening()[data::kLimbOrder * k + n]) * 2 / (double(n) + 2);
    table.wavelengths.push_back(static_cast<float>(kFirstWavelength + kWavelengthStep * double(k)));
    table.values.push_back(static_cast<float>(std::max(center * limb, 0.0)));
  }
  return table;
}

Vec3f sun_rgb(const SpectrumDescription::Table& spectrum) {
  constexpr float kWeight = 0.397846f;
  Vec3f xyz{0, 0, 0};
  for (std::size_t k = 0; k < spectrum.values.size(); ++k)
    xyz = xyz + cie_1931_xyz(spectrum.wavelengths[k]) * (kWeight * spectrum.values[k]);
  const Vec3f rgb = xyz_to_rec709(xyz);
  return {std::max(rgb.x, 0.0f), std::max(rgb.y, 0.0f), std::max(rgb.z, 0.0f)};
}

Vec3f stretched(Vec3f direction, Vec3f up, float factor) {
  const Vec3f across = direction - up * dot(direction, up);
  const float sine = length(across);
  if (factor == 1.0f || !(sine > 0.0f)) return direction;
  const float angle = std::atan2(sine, dot(direction, up)) * factor;
  return up * std::cos(angle) + across * (std::sin(angle) / sine);
}

EnvmapImage sky_image(const SkyDescription& sky, Vec3f front) {
  EnvmapImage image;
  image.width = static_cast<std::uint32_t>(sky.resolution);
  image.height = std::max(image.width / 2, 2u);
  image.rgb.resize(3 * std::size_t{image.width} * image.height);
  // Average the skies of all suns, node by node
  const Frame<Scalar> frame{cross(sky.up, front), sky.up, front};
  const Skies skies(sky);
  tbb::parallel_for(std::uint32_t{0}, image.height, [&](std::uint32_t j) {
    // Compute the polar angle of the row
    double polar = kPiD * j / (image.height - 1) / double(sky.stretch);
    if (polar > 0.5 * kPiD && !sky.extend) return;
    polar = std::min(polar, 0.5 * kPiD);
    for (std::uint32_t i = 0; i < image.width; ++i) {
      // Evaluate the sky in the direction of the node
      const double longitude = 2 * kPiD * (i + 0.5) / image.width;
      const double local[3] = {std::sin(longitude) * std::sin(polar), std::cos(polar),
                               -std::cos(longitude) * std::sin(polar)};
      const Vec3f direction =
          frame.to_world({static_cast<float>(local[0]), static_cast<float>(local[1]), static_cast<float>(local[2])});
      const auto rgb = skies.radiance(direction, std::max(local[1], 0.0));
      for (std::size_t c = 0; c < 3; ++c)
        image.rgb[3 * (std::size_t{j} * image.width + i) + c] =
            static_cast<float>(std::max(rgb[c] * double(sky.scale), 0.0));
    }
  });
  if (sky.sun_scale > 0.0f) add_suns(sky, frame, image);
  return image;
}

}  // namespace sheaf

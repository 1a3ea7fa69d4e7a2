#include "core/image/display_transform.h"

#include "core/color/color.h"
#include "core/image/display_channels.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace sheaf {

namespace {

constexpr double kMiddleGray = 0.18;
/// Exponent of the sRGB curve (IEC 61966-2-1): the weights of luminances are about the values that a display receives.
constexpr double kEncodingExponent = 1 / 2.4;
/// Stops from middle gray down to the first level of an 8-bit sRGB image above black, 1/255 on the linear segment of
/// the curve, whose slope is 12.92: log2(0.18 x 12.92 x 255).
const double kFaintStops = std::log2(kMiddleGray * 12.92 * 255);

/// Least coverage by which colors are divided: the first level of 8 bits.
constexpr double kMinCoverage = 1.0 / 255;

/// The luminance of a pixel with light, log2.
struct LitPixel {
  double level;           ///< over black
  double straight_level;  ///< divided by the coverage, unless that is below kMinCoverage
};

/// The color channels of a pixel; gray as three equal ones.
Vec3f color_of(const float* pixel, const DisplayChannels& channels) {
  const std::size_t last = channels.color.size() - 1;
  return {pixel[channels.color[0]], pixel[channels.color[std::min<std::size_t>(1, last)]], pixel[channels.color[last]]};
}

/// An image of black pixels with the displayed channels and the window of `image`.
Image prepare_display(const Image& image, const DisplayChannels& channels) {
  Image out;
  out.width = image.width;
  out.height = image.height;
  out.x0 = image.x0;
  out.y0 = image.y0;
  out.frame_width = image.frame_width;
  out.frame_height = image.frame_height;
  for (const int c : channels.color) out.channels.push_back(image.channels[static_cast<std::size_t>(c)]);
  if (channels.alpha >= 0) out.channels.emplace_back("A");
  out.data.resize(out.pixel_count() * out.channels.size());
  return out;
}

/// Writes the colors times 2^stops, and alpha.
void expose(const Image& image, const DisplayChannels& channels, double stops, Image& out) {
  const auto scale = static_cast<float>(std::exp2(stops));
  const std::size_t colors = channels.color.size();
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float* const from = &image.data[i * image.channels.size()];
    float* const to = &out.data[i * out.channels.size()];
    for (std::size_t c = 0; c < colors; ++c) to[c] = from[channels.color[c]] * scale;
    if (channels.alpha >= 0) to[colors] = from[channels.alpha];
  }
}

std::vector<LitPixel> lit_pixels(const Image& image) {
  const DisplayChannels channels = display_channels(image);
  std::vector<LitPixel> out;
  out.reserve(image.pixel_count());
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float* const pixel = &image.data[i * image.channels.size()];
    const auto value = static_cast<double>(luminance(color_of(pixel, channels)));
    if (!(value > 0) || !std::isfinite(value)) continue;
    const double alpha = channels.alpha < 0 ? 1.0 : static_cast<double>(pixel[channels.alpha]);
    const double level = std::log2(value);
    out.push_back({level, alpha >= kMinCoverage && alpha < 1 ? level - std::log2(alpha) : level});
  }
  return out;
}

/// The log-average of the brighter part of an image: luminances have the weights of their encoded values, so that
/// neither many faint pixels nor few bright ones, such as the disc of the sun, decide alone.
double bright_level(const std::vector<LitPixel>& pixels) {
  double sum = 0, weights = 0;
  for (const LitPixel& pixel : pixels) {
    const double weight = std::exp2(kEncodingExponent * pixel.level);
    sum += weight * pixel.level;
    weights += weight;
  }
  return sum / weights;
}

/// A value that OpenColorIO may receive: NaN becomes 0, and infinity the largest half.
float finite(float value) {
  constexpr float kMaxHalf = 65504;
  return std::isnan(value) ? 0.0f : std::clamp(value, -kMaxHalf, kMaxHalf);
}

}  // namespace

double auto_exposure(const Image& image) {
  if (image.channels.empty()) return 0;
  const std::vector<LitPixel> pixels = lit_pixels(image);
  if (pixels.empty()) return 0;
  const double faintest = bright_level(pixels) - kFaintStops;
  double sum = 0;
  std::uint64_t count = 0;
  for (const LitPixel& pixel : pixels) {
    if (pixel.level < faintest) continue;
    sum += pixel.straight_level;
    ++count;
  }
  // The brightest pixel counts, because its level is not below any mean. Limit the exposure to finite factors
  constexpr double kMaxStops = std::numeric_limits<float>::max_exponent - 2;
  return std::min(std::log2(kMiddleGray) - sum / static_cast<double>(count), kMaxStops);
}

Shown shown_by(const Image& displayed) {
  constexpr double kShare = 0.99;         // of the pixels
  constexpr float kBlackLevel = 0.0015f;  // about the fifth of 255 levels of sRGB
  constexpr float kWhiteLevel = 0.99f;
  if (displayed.channels.empty()) return Shown::kPicture;
  const DisplayChannels channels = display_channels(displayed);
  const std::size_t stride = displayed.channels.size();
  std::size_t count = 0, black = 0, white = 0;
  for (std::size_t first = 0; first < displayed.data.size(); first += stride) {
    const float* const pixel = &displayed.data[first];
    const float alpha = display_alpha(pixel, channels);
    if (!(alpha > 0)) continue;
    const Vec3f color = color_of(pixel, channels) * (1 / alpha);
    ++count;
    black += std::max({color.x, color.y, color.z}) < kBlackLevel;
    white += std::min({color.x, color.y, color.z}) > kWhiteLevel;
  }
  const double needed = kShare * static_cast<double>(count);
  if (count == 0) return Shown::kPicture;
  return static_cast<double>(black) >= needed   ? Shown::kBlack
         : static_cast<double>(white) >= needed ? Shown::kWhite
                                                : Shown::kPicture;
}

double DisplayTransform::exposure_of(const Image& image) const {
  return settings_.exposure ? *settings_.exposure : auto_exposure(image);
}

Image DisplayTransform::apply(const Image& image) const {
  if (image.channels.empty()) return image;
  const DisplayChannels channels = display_channels(image);
  Image out = prepare_display(image, channels);
  expose(image, channels, exposure_of(image), out);
  if (settings_.tone_map == ToneMap::kClamp && !settings_.display_view) return out;

  const DisplayChannels own = display_channels(out);
  const std::size_t stride = out.channels.size();
  std::vector<Vec3f> row(static_cast<std::size_t>(out.width));
  std::vector<float> alphas(row.size());
  for (std::size_t first = 0; first < out.data.size(); first += row.size() * stride) {
    // Read the straight colors of a row
    for (std::size_t x = 0; x < row.size(); ++x) {
      const float* const pixel = &out.data[first + x * stride];
      alphas[x] = display_alpha(pixel, own);
      row[x] = alphas[x] > 0 ? color_of(pixel, own) * (1 / alphas[x]) : Vec3f{};
    }
    map_colors(row);
    // Write them, premultiplied
    for (std::size_t x = 0; x < row.size(); ++x) {
      float* const pixel = &out.data[first + x * stride];
      const float mapped[3] = {row[x].x, row[x].y, row[x].z};
      for (std::size_t c = 0; c < own.color.size(); ++c) pixel[own.color[c]] = mapped[c] * alphas[x];
      if (own.alpha >= 0) pixel[own.alpha] = alphas[x];
    }
  }
  return out;
}

void DisplayTransform::map_colors(std::vector<Vec3f>& colors) const {
  if (!settings_.display_view) {
    for (Vec3f& color : colors) color = tone_mapped(settings_.tone_map, color);
    return;
  }
  for (Vec3f& color : colors) color = {finite(color.x), finite(color.y), finite(color.z)};
  settings_.display_view->apply(&colors[0].x, colors.size());
  for (Vec3f& color : colors) color = srgb_to_linear(tone_mapped(ToneMap::kClamp, color));
}

}  // namespace sheaf

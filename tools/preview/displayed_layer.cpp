#include "tools/preview/displayed_layer.h"

#include "core/color/color.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf {

namespace {

/// The channels of a layer, its single channel three times; -1 if they are absent.
std::array<int, 3> channels_of(const Image& image, const AovEntry& entry) {
  std::array<int, 3> channels{-1, -1, -1};
  for (std::size_t c = 0; c < 3; ++c)
    channels[c] = image.find_channel(entry.channels[entry.channels[1].empty() ? 0 : c]);
  return channels;
}

/// The depths within which most pixels lie.
struct DepthRange {
  float near = 0, far = 1;

  DepthRange(const Image& image, int depth) {
    constexpr int kReach = 4;  // filters mix depths with zeros on both sides of outlines
    const auto is_covered = [&](int x, int y) {
      return image.at(std::clamp(x, 0, image.width - 1), std::clamp(y, 0, image.height - 1), depth) > 0;
    };
    std::vector<float> depths;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const bool is_inside = is_covered(x - kReach, y) && is_covered(x + kReach, y) && is_covered(x, y - kReach) &&
                               is_covered(x, y + kReach);
        const float z = image.at(x, y, depth);
        if (is_inside && z > 0 && std::isfinite(z)) depths.push_back(z);
      }
    if (depths.empty()) return;
    const auto quantile = [&](double share) {
      const auto at = depths.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(depths.size() - 1));
      std::nth_element(depths.begin(), at, depths.end());
      return *at;
    };
    near = quantile(0.01), far = quantile(0.99);
  }

  float brightness(float depth) const {
    constexpr float kFarthest = 0.06f;  // distinguishable from pixels without a surface
    if (!(depth > 0)) return 0;
    const float share = (depth - near) / std::max(far - near, 1e-3f * far);
    return 1 - (1 - kFarthest) * std::clamp(share, 0.0f, 1.0f);
  }
};

}  // namespace

AovSet page_layers(const IntegratorSettings& integrator) {
  AovSet layers;
  if (!integrator.traits().follows_camera_paths() || integrator.max_depth == 1 || integrator.max_depth == 0)
    return layers;
  for (const Aov aov : kShownLayers) layers.insert(aov);
  return layers;
}

std::vector<std::string_view> shown_layers(const Image& image) {
  std::vector<std::string_view> names;
  for (const Aov aov : kShownLayers)
    if (channels_of(image, entry_of(aov))[0] >= 0) names.push_back(entry_of(aov).name);
  return names;
}

Image displayed_layer(const Image& image, std::string_view layer) {
  const auto* const entry =
      std::find_if(kAovList.begin(), kAovList.end(), [&](const AovEntry& aov) { return aov.name == layer; });
  if (entry == kAovList.end()) return {};
  const std::array<int, 3> from = channels_of(image, *entry);
  if (from[0] < 0) return {};
  const bool is_of_surfaces = entry->source == AovSource::kVertex;
  const int depth = is_of_surfaces ? image.find_channel(entry_of(aov_named("depth")).channels[0]) : -1;
  const bool is_normal = entry->aov == aov_named("normal") || entry->aov == aov_named("geometric_normal"),
             is_depth = entry->aov == aov_named("depth");
  const DepthRange range = is_depth ? DepthRange(image, from[0]) : DepthRange(Image(), 0);
  Image out(image.width, image.height, {"R", "G", "B", "A"});
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float* const pixel = &image.data[i * image.channels.size()];
    const bool is_covered = depth < 0 || pixel[depth] > 0;
    const auto color = [&](std::size_t c) {
      const float value = from[c] >= 0 ? pixel[from[c]] : 0.0f;
      if (is_depth) return range.brightness(value);
      return is_normal ? 0.5f + 0.5f * value : value;
    };
    Vec3f rgb{color(0), color(1), color(2)};
    if (is_normal || is_depth) rgb = srgb_to_linear(rgb);
    const float values[4] = {rgb.x, rgb.y, rgb.z, 1};
    for (std::size_t c = 0; c < 4; ++c) out.data[4 * i + c] = is_covered ? values[c] : 0;
  }
  return out;
}

}  // namespace sheaf

#include "tools/cli/image_layers.h"

#include "core/io/error.h"
#include "kernels/film/aovs.h"
#include "tools/preview/displayed_layer.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace sheaf {

namespace {

/// Layers that an error lists.
constexpr std::size_t kMaxListed = 24;

/// Endings of the channels of a layer, in the order of R, G, B and A.
constexpr std::array<std::array<const char*, 4>, 5> kEndings = {
    {{"R", "G", "B", "A"}, {"r", "g", "b", "a"}, {"X", "Y", "Z", ""}, {"U", "V", "", ""}, {"u", "v", "", ""}}};

/// Whether the channels of an AOV can be shown as an image. Those of Cryptomatte are ids.
bool is_picture(const AovEntry& aov) { return !aov.name.starts_with("cryptomatte"); }

const AovEntry* find_aov(const Image& image, std::string_view name) {
  for (const AovEntry& aov : kAovList)
    if (aov.name == name && is_picture(aov) && image.find_channel(aov.channels[0]) >= 0) return &aov;
  return nullptr;
}

bool is_of_aov(const std::string& channel) {
  return std::any_of(kAovList.begin(), kAovList.end(), [&](const AovEntry& aov) {
    return is_picture(aov) && std::find(aov.channels.begin(), aov.channels.end(), channel) != aov.channels.end();
  });
}

/// The channels of a layer; empty if the image does not have it.
std::vector<int> channels_of(const Image& image, const std::string& name) {
  std::vector<int> channels;
  const auto add = [&](const std::string& channel) {
    if (const int index = image.find_channel(channel); index >= 0) channels.push_back(index);
  };
  if (const AovEntry* const aov = find_aov(image, name); aov != nullptr) {
    for (const std::string_view channel : aov->channels) add(std::string(channel));
    return channels;
  }
  const std::string prefix = name == kImageLayer ? "" : name + ".";
  for (const auto& endings : kEndings) {
    for (const std::string ending : endings)
      if (!ending.empty()) add(prefix + ending);
    if (!channels.empty()) return channels;
  }
  add(name);
  return channels;
}

[[noreturn]] void refuse(const Image& image, const std::string& name) {
  std::vector<std::string> names = layer_names(image);
  const std::string near = did_you_mean(name, names);
  std::string more;
  if (names.size() > kMaxListed) {
    more = fmt::format(", and {} more", names.size() - kMaxListed);
    names.resize(kMaxListed);
  }
  throw Error(ExitCode::kUsage, fmt::format("--layer {}: the image has no such layer{} (layers: {}{})", name, near,
                                            fmt::join(names, ", "), more));
}

}  // namespace

std::vector<std::string> layer_names(const Image& image) {
  std::vector<std::string> names;
  const auto add = [&](std::string name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
  };
  if (image.find_channel("R") >= 0) add(kImageLayer);
  for (const AovEntry& aov : kAovList)
    if (find_aov(image, aov.name) != nullptr) add(std::string(aov.name));
  for (const std::string& channel : image.channels) {
    if (is_of_aov(channel)) continue;
    const std::size_t dot = channel.rfind('.');
    const std::string prefix = channel.substr(0, dot == std::string::npos ? 0 : dot);
    const std::vector<int> layer = channels_of(image, prefix.empty() ? kImageLayer : prefix);
    const bool is_in_layer = std::any_of(layer.begin(), layer.end(),
                                         [&](int c) { return image.channels[static_cast<std::size_t>(c)] == channel; });
    add(!is_in_layer ? channel : prefix.empty() ? kImageLayer : prefix);
  }
  return names;
}

Image layer_of(const Image& image, const std::string& name, bool displayed) {
  const std::vector<int> channels = channels_of(image, name);
  if (channels.empty()) refuse(image, name);
  Image out;
  if (displayed && find_aov(image, name) != nullptr) {
    out = displayed_layer(image, name);
  } else {
    out = Image(image.width, image.height, {"Y"});
    if (channels.size() > 1) out = Image(image.width, image.height, {"R", "G", "B"});
    if (channels.size() > 3) out = Image(image.width, image.height, {"R", "G", "B", "A"});
    for (std::size_t i = 0; i < image.pixel_count(); ++i)
      for (std::size_t c = 0; c < channels.size(); ++c)
        out.data[i * out.channels.size() + c] =
            image.data[i * image.channels.size() + static_cast<std::size_t>(channels[c])];
  }
  out.x0 = image.x0;
  out.y0 = image.y0;
  out.frame_width = image.frame_width;
  out.frame_height = image.frame_height;
  return out;
}

}  // namespace sheaf

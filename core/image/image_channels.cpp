// The search for color channels by name.
#include "core/image/image_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

namespace sheaf {

namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

/// A channel name, split into layer and channel, in lower case.
struct SplitName {
  std::string layer, channel;
};
SplitName split(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == name.npos) return {"", lower(name)};
  return {lower(name.substr(0, dot)), lower(name.substr(dot + 1))};
}

/// Whether a channel is alpha, or the alpha of one color.
bool is_alpha(std::string_view channel) {
  constexpr std::array<std::string_view, 5> kNames{"a", "alpha", "ar", "ag", "ab"};
  return std::find(kNames.begin(), kNames.end(), channel) != kNames.end();
}

/// Whether a layer holds the image itself, by the last part of its name.
bool is_main(std::string_view layer) {
  constexpr std::array<std::string_view, 7> kNames{"beauty", "color", "colour", "combined", "main", "rgb", "rgba"};
  return std::find(kNames.begin(), kNames.end(), layer.substr(layer.rfind('.') + 1)) != kNames.end();
}

class Finder {
 public:
  explicit Finder(std::span<const ImageChannels> parts) {
    for (const ImageChannels& part : parts) {
      std::vector<SplitName>& names = parts_.emplace_back();
      for (const std::string& name : part.names) names.push_back(split(name));
    }
  }

  /// Finds the color channels, and the alpha channel of their layer.
  std::optional<ColorChannels> find() const {
    std::optional<ColorChannels> found = find_colors();
    if (!found) return found;
    const std::vector<SplitName>& names = parts_[found->part];
    const std::string& layer = names[found->channels[0]].layer;
    for (std::size_t c = 0; c < names.size(); ++c)
      if (names[c].layer == layer && (names[c].channel == "a" || names[c].channel == "alpha") &&
          c != found->channels[0])
        found->alpha = c;
    return found;
  }

 private:
  std::optional<ColorChannels> find_colors() const {
    for (const auto& names : {kRgb, kColors})
      for (std::size_t part = 0; part < parts_.size(); ++part)
        if (auto found = three(part, "", names)) return found;
    for (std::size_t part = 0; part < parts_.size(); ++part)
      if (auto found = three(part, "", kXyz)) {
        found->xyz = true;
        return found;
      }
    if (auto found = in_layers()) return found;
    return gray();
  }

  using Names = std::array<std::string_view, 3>;
  static constexpr Names kRgb{"r", "g", "b"}, kColors{"red", "green", "blue"}, kXyz{"x", "y", "z"};

  std::optional<ColorChannels> three(std::size_t part, std::string_view layer, const Names& requested) const {
    ColorChannels found{part, {}, false, {}};
    const std::vector<SplitName>& names = parts_[part];
    for (const std::string_view channel : requested) {
      const auto at = std::find_if(names.begin(), names.end(), [&](const SplitName& name) {
        return name.layer == layer && name.channel == channel;
      });
      if (at == names.end()) return std::nullopt;
      found.channels.push_back(static_cast<std::size_t>(at - names.begin()));
    }
    return found;
  }

  /// R, G and B of the main layer, or of the only layer that has them.
  std::optional<ColorChannels> in_layers() const {
    std::vector<ColorChannels> all;
    for (std::size_t part = 0; part < parts_.size(); ++part)
      for (const SplitName& name : parts_[part]) {
        if (name.channel != kRgb[0]) continue;
        auto found = three(part, name.layer, kRgb);
        if (found && is_main(name.layer)) return found;
        if (found) all.push_back(*found);
      }
    if (all.size() != 1) return std::nullopt;
    return all[0];
  }

  /// The only channel besides alpha in the file; or Y, if it is the only one outside of layers in the first part; or
  /// alpha, if it is the only channel.
  std::optional<ColorChannels> gray() const {
    std::vector<ColorChannels> all, outside, alphas;
    for (std::size_t part = 0; part < parts_.size(); ++part)
      for (std::size_t c = 0; c < parts_[part].size(); ++c) {
        const bool alpha = is_alpha(parts_[part][c].channel);
        (alpha ? alphas : all).push_back({part, {c}, false, {}});
        if (alpha) continue;
        if (part == 0 && parts_[part][c].layer.empty()) outside.push_back(all.back());
      }
    if (all.size() == 1) return all[0];
    if (outside.size() == 1 && parts_[0][outside[0].channels[0]].channel == "y") return outside[0];
    if (all.empty() && alphas.size() == 1) return alphas[0];
    return std::nullopt;
  }

  std::vector<std::vector<SplitName>> parts_;
};

/// Lists the names of all channels, truncated after about 600 characters.
std::string list_of(std::span<const ImageChannels> parts) {
  constexpr std::size_t kMaxLength = 600;
  std::string list;
  for (const ImageChannels& part : parts) {
    list += list.empty() ? "" : "; ";
    if (parts.size() > 1) list += fmt::format("part '{}': ", part.part);
    for (std::size_t c = 0; c < part.names.size(); ++c) {
      if (list.size() > kMaxLength) return list + " ...";
      list += (c == 0 ? "" : ", ") + part.names[c];
    }
  }
  for (char& c : list)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return list;
}

}  // namespace

ColorChannels find_color_channels(std::span<const ImageChannels> parts, const SourceLocation& where) {
  if (const auto found = Finder(parts).find()) return *found;
  throw SceneError(where, fmt::format("no colors among the channels {} (expected R, G and B, or X, Y and Z, or one "
                                      "channel, optionally with A)",
                                      list_of(parts)));
}

ColorChannels find_color_channels(const std::vector<std::string>& names, const SourceLocation& where) {
  const ImageChannels part{"", names};
  return find_color_channels({&part, 1}, where);
}

}  // namespace sheaf

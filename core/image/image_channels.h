// Selection of the color channels of an image file.
#pragma once

#include "core/io/error.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// The channels of one part of an image file. Only OpenEXR files have several parts.
struct ImageChannels {
  std::string part;                ///< name; may be empty
  std::vector<std::string> names;  ///< "layer.channel", or "channel" outside of layers
};

/// The color channels of an image.
struct ColorChannels {
  std::size_t part = 0;
  std::vector<std::size_t> channels;  ///< indices into ImageChannels::names: red, green and blue, or one for gray
  bool xyz = false;                   ///< the three are CIE X, Y and Z
  std::optional<std::size_t> alpha;   ///< alpha channel of the same layer
};

/// Finds the color channels. Names match in any case. The search order is: R, G and B, or red, green and blue, outside
/// of layers; X, Y and Z outside of layers; R, G and B of a layer named Combined, beauty, color, color, main, rgb or
/// rgba, or of the only layer that has them; the only channel besides alpha in the file; Y, if no other channel besides
/// alpha is outside of layers in the first part; alpha, if it is the only channel. Of several parts the first match
/// is used. Throws SceneError that lists the channels if nothing matches.
ColorChannels find_color_channels(std::span<const ImageChannels> parts, const SourceLocation& where);

/// The same for a file of one part.
ColorChannels find_color_channels(const std::vector<std::string>& names, const SourceLocation& where);

}  // namespace sheaf

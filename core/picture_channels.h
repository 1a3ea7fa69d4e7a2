// Which of a picture's channels are its colours.
#pragma once

#include "core/error.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// A part of a picture file, by its channels. Only OpenEXR has files of several.
struct PictureChannels {
  std::string part;                ///< name; may be empty
  std::vector<std::string> names;  ///< "layer.channel", or a channel of no layer
};

/// The colours of a picture.
struct ColorChannels {
  std::size_t part = 0;
  std::vector<std::size_t> channels;  ///< indices into PictureChannels::names: red, green and blue, or one for grey
  bool xyz = false;                   ///< the three are CIE X, Y and Z
  std::optional<std::size_t> alpha;   ///< of the same layer
};

/// Finds R, G and B (in capitals or small letters) outside of layers; else X, Y and Z there; else R, G and B of the one
/// layer that has them, or of one called Combined, beauty, color, colour, main, rgb or rgba; else the only channel
/// besides alpha, in the file or outside of layers. Of several parts the first one counts. Throws SceneError that lists
/// the channels where that leaves none.
ColorChannels find_color_channels(std::span<const PictureChannels> parts, const SourceLocation& where);

/// The same for a file of one part.
ColorChannels find_color_channels(const std::vector<std::string>& names, const SourceLocation& where);

}  // namespace sheaf

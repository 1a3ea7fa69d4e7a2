// Selection of the channels of a rendered image that files without layers show.
#pragma once

#include "core/image/image.h"

namespace sheaf {

/// Channel indices: three for R, G and B, or if one of them is missing, one for R, or else the first channel, as gray.
/// And one for A, or -1 without it.
struct DisplayChannels {
  std::vector<int> color;
  int alpha = -1;
};
DisplayChannels display_channels(const Image& image);

/// The alpha of a pixel in a file. Light that adds to the background, as of a flame, has less alpha than color. Files
/// with straight alpha cannot express that: their alpha is that of the brightest color, at most 1, which keeps the
/// image over black. `pixel`: the values of all channels.
float display_alpha(const float* pixel, const DisplayChannels& channels);

}  // namespace sheaf

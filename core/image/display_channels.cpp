#include "core/image/display_channels.h"

#include <algorithm>

namespace sheaf {

DisplayChannels display_channels(const Image& image) {
  DisplayChannels chosen;
  const int red = image.find_channel("R"), green = image.find_channel("G"), blue = image.find_channel("B");
  if (red >= 0 && green >= 0 && blue >= 0) {
    chosen.color = {red, green, blue};
  } else {
    chosen.color = {std::max(red, 0)};
  }
  const int alpha = image.find_channel("A");
  chosen.alpha = alpha == chosen.color[0] ? -1 : alpha;
  return chosen;
}

float display_alpha(const float* pixel, const DisplayChannels& channels) {
  if (channels.alpha < 0) return 1.0f;
  float brightest = 0;
  for (const int c : channels.color) brightest = std::max(brightest, pixel[c]);
  return std::max(pixel[channels.alpha], std::min(brightest, 1.0f));
}

}  // namespace sheaf

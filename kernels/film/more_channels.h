// Adding channels to images.
#pragma once

#include "core/image/image.h"

#include <algorithm>

namespace sheaf {

/// Returns a copy of the image with more channels after its own; the new channels are zero.
inline Image with_channels(const Image& image, const std::vector<std::string>& more) {
  std::vector<std::string> names = image.channels;
  names.insert(names.end(), more.begin(), more.end());
  Image out(image.width, image.height, std::move(names));
  out.x0 = image.x0;
  out.y0 = image.y0;
  out.frame_width = image.frame_width;
  out.frame_height = image.frame_height;
  const std::size_t from = image.channels.size(), to = out.channels.size();
  for (std::size_t pixel = 0; pixel < image.pixel_count(); ++pixel)
    std::copy_n(image.data.begin() + static_cast<std::ptrdiff_t>(pixel * from), from,
                out.data.begin() + static_cast<std::ptrdiff_t>(pixel * to));
  return out;
}

}  // namespace sheaf

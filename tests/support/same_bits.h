// Renders whose bits must not depend on how the work is divided.
#pragma once

#include "kernels/render/render.h"

#include <doctest/doctest.h>

#include <initializer_list>

namespace sheaf {

/// Checks that an image of at least 14 x 14 pixels has the same bits for all combinations of thread counts and wave
/// sizes, and that a crop of it has the same pixels. `options`: of all renders.
inline void check_same_bits(const Scene& scene, std::initializer_list<int> wave_sizes = {64, 256, 1000},
                            const RenderOptions& options = {}) {
  const Image whole = render(scene, options).to_image();
  for (const int threads : {1, 2, 7})
    for (const int wave_size : wave_sizes) {
      CAPTURE(threads);
      CAPTURE(wave_size);
      RenderOptions divided = options;
      divided.threads = threads;
      divided.wave_size = wave_size;
      CHECK(render(scene, divided).to_image().data == whole.data);
    }
  RenderOptions cropped = options;
  cropped.crop = PixelRect{3, 5, 11, 9};
  const Image crop = render(scene, cropped).to_image();
  bool same = true;
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x)
      for (int c = 0; c < static_cast<int>(crop.channels.size()); ++c)
        same = same && crop.at(x, y, c) == whole.at(x + 3, y + 5, c);
  CHECK(same);
}

}  // namespace sheaf

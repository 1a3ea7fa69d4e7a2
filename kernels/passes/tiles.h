// How the frame is cut into tiles.
#pragma once

#include "core/pixel_rect.h"

#include <vector>

namespace sheaf {

/// A square of pixels of the frame, and those of them whose samples are wanted.
struct Tile {
  PixelRect pixels, wanted;
};

/// Squares of `side` pixels, counted from the frame's corner, that hold any of the `wanted` pixels, row by row.
inline std::vector<Tile> make_tiles(const PixelRect& wanted, int side) {
  std::vector<Tile> tiles;
  const auto tile_begin = [side](int at) { return (at >= 0 ? at / side : -((side - 1 - at) / side)) * side; };
  for (int y = tile_begin(wanted.y0); y < wanted.y1; y += side)
    for (int x = tile_begin(wanted.x0); x < wanted.x1; x += side) {
      const PixelRect pixels{x, y, x + side, y + side};
      tiles.push_back({pixels, pixels.intersection(wanted)});
    }
  return tiles;
}

}  // namespace sheaf

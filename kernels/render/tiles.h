// Division of the frame into tiles.
#pragma once

#include "core/image/pixel_rect.h"

#include <cstdint>
#include <vector>

namespace sheaf {

/// Camera samples per task: many enough that the wave is full most of the time, few enough that their buffer stays in
/// the caches.
inline constexpr int kTaskSamples = 16384;
/// Maximum samples per pixel and pass. A barrier separates passes; within a pass each tile has one owner.
inline constexpr std::uint32_t kPassSamples = 256;
/// Side of the tiles of adaptive sampling, pixels.
inline constexpr int kAdaptiveSide = 16;

/// Side of the tiles of a pass of `samples` samples per pixel, pixels.
inline int tile_side(std::uint32_t samples) {
  int side = 8;
  while (side < 64 && 4 * side * side * static_cast<int>(samples) <= kTaskSamples) side *= 2;
  return side;
}

/// A square of pixels of the frame. `sampled`: the part of it that is sampled.
struct Tile {
  PixelRect pixels, sampled;
};

/// Squares of `side` pixels, aligned to the frame's corner, that contain `sampled` pixels; row by row.
inline std::vector<Tile> make_tiles(const PixelRect& sampled, int side) {
  std::vector<Tile> tiles;
  const auto tile_begin = [side](int at) { return (at >= 0 ? at / side : -((side - 1 - at) / side)) * side; };
  for (int y = tile_begin(sampled.y0); y < sampled.y1; y += side)
    for (int x = tile_begin(sampled.x0); x < sampled.x1; x += side) {
      const PixelRect pixels{x, y, x + side, y + side};
      tiles.push_back({pixels, pixels.intersection(sampled)});
    }
  return tiles;
}

}  // namespace sheaf

// Rectangles of pixels.
#pragma once

#include <algorithm>
#include <cstdint>

namespace sheaf {

/// Half-open pixel rectangle.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  /// Number of pixels. Requires x0 <= x1 and y0 <= y1.
  std::uint64_t area() const { return static_cast<std::uint64_t>(width()) * static_cast<std::uint64_t>(height()); }
  bool is_empty() const { return x1 <= x0 || y1 <= y0; }

  /// The rectangle, enlarged by `border` pixels on each side.
  PixelRect grown(int border) const { return {x0 - border, y0 - border, x1 + border, y1 + border}; }
  /// The intersection of two rectangles; PixelRect{} if they are disjoint.
  PixelRect intersection(const PixelRect& other) const {
    const PixelRect both{std::max(x0, other.x0), std::max(y0, other.y0), std::min(x1, other.x1),
                         std::min(y1, other.y1)};
    return both.is_empty() ? PixelRect{} : both;
  }
  bool operator==(const PixelRect&) const = default;
};

}  // namespace sheaf

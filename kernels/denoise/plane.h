// One channel of an image with a border, for filters that read the neighbors of many pixels at a time.
#pragma once

#include "core/simd/lanes.h"
#include "core/soa/large_table.h"

#include <array>
#include <cstring>
#include <type_traits>

namespace sheaf {

/// Rows of floats whose first pixels are aligned to cache lines. A border of kBorderX columns and kBorderY rows
/// surrounds the pixels. It is zero until extend() is called, and may be read and written like pixels.
class Plane {
 public:
  static constexpr int kBorderX = 32, kBorderY = 16;

  Plane() = default;
  Plane(int width, int height)
      : width_(width),
        height_(height),
        stride_((width + 2 * kBorderX + 15) / 16 * 16),
        values_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 2 * kBorderY)) {}

  int width() const { return width_; }
  int height() const { return height_; }
  bool is_empty() const { return values_.empty(); }
  /// First pixel of a row; -kBorderY <= y < height + kBorderY.
  float* row(int y) { return values_.data() + offset(y); }
  const float* row(int y) const { return values_.data() + offset(y); }
  float& at(int x, int y) { return row(y)[x]; }
  float at(int x, int y) const { return row(y)[x]; }

  /// Fills the border and the padding of rows with the value of the nearest pixel.
  void extend() {
    for (int y = 0; y < height_; ++y) {
      float* const r = row(y);
      std::fill(r - kBorderX, r, r[0]);
      std::fill(r + width_, r + stride_ - kBorderX, r[width_ - 1]);
    }
    const auto bytes = static_cast<std::size_t>(stride_) * sizeof(float);
    for (int y = 1; y <= kBorderY; ++y) {
      std::memcpy(row(-y) - kBorderX, row(0) - kBorderX, bytes);
      std::memcpy(row(height_ - 1 + y) - kBorderX, row(height_ - 1) - kBorderX, bytes);
    }
  }

 private:
  std::ptrdiff_t offset(int y) const { return static_cast<std::ptrdiff_t>(y + kBorderY) * stride_ + kBorderX; }

  int width_ = 0, height_ = 0, stride_ = 0;
  LargeTable<float> values_;
};

/// Red, green and blue, or any other three.
using Planes3 = std::array<Plane, 3>;

/// Loads L::width values from an unaligned address.
template <class L> SHEAF_INLINE Float<L> load_at(const float* p) {
  static_assert(std::is_trivially_copyable_v<Float<L>>);
  Float<L> value;
  std::memcpy(static_cast<void*>(&value), p, sizeof(float) * L::width);
  return value;
}

}  // namespace sheaf

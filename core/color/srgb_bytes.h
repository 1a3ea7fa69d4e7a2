// The sRGB curve of bytes.
#pragma once

#include "core/color/color.h"

#include <array>
#include <cstddef>

namespace sheaf {

/// srgb_to_linear() of each byte's value, in 255ths.
inline const std::array<float, 256>& linear_of_srgb_bytes() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = srgb_to_linear(static_cast<float>(i) / 255.0f);
    return values;
  }();
  return table;
}

}  // namespace sheaf

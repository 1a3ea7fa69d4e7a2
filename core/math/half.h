// Numbers of 16 bits (IEEE 754 binary16).
#pragma once

#include <bit>
#include <cstdint>

namespace sheaf {

/// Converts binary16 to float, exactly.
inline float half_to_float(std::uint16_t half) {
  constexpr std::uint32_t kExponent = 0x7c00, kBias = (127 - 15) << 10;
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000) << 16, magnitude = half & 0x7fff;
  if (magnitude < 0x400)  // zero or subnormal
    return (sign != 0 ? -0x1p-24f : 0x1p-24f) * static_cast<float>(magnitude);
  const std::uint32_t infinite = magnitude >= kExponent ? 0x7f800000u : 0;
  return std::bit_cast<float>(sign | infinite | (magnitude + kBias) << 13);
}

}  // namespace sheaf

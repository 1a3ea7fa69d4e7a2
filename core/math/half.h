// Numbers of 16 bits (IEEE 754 binary16).
#pragma once

#include <bit>
#include <cmath>
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

/// Converts a finite float to binary16, rounded to the nearest, ties to even; infinite from 65520.
inline std::uint16_t float_to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000, magnitude = bits & 0x7fffffff;
  const float absolute = std::bit_cast<float>(magnitude);
  std::uint32_t half = 0x7c00;
  if (absolute < 0x1p-14f)  // zero or subnormal
    half = static_cast<std::uint32_t>(std::lrint(absolute * 0x1p24f));
  else if (absolute < 65520.0f)
    half = ((magnitude + 0xfff + (magnitude >> 13 & 1)) >> 13) - ((127 - 15) << 10);
  return static_cast<std::uint16_t>(sign | half);
}

}  // namespace sheaf

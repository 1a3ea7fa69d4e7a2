// Conversion of untrusted numbers to integers without overflow.
#pragma once

#include <limits>
#include <type_traits>

namespace sheaf {

/// Truncates the value and clamps it to the range of To; NaN becomes 0. Round the value first if needed. A plain cast
/// of a value out of range is undefined.
template <class To> constexpr To saturate(double value) {
  static_assert(std::is_integral_v<To>);
  using Limits = std::numeric_limits<To>;
  if (value != value) return 0;
  // The maximum of a 64-bit integer is no double; it converts to the next power of two.
  if (value >= static_cast<double>(Limits::max())) return Limits::max();
  if (value <= static_cast<double>(Limits::min())) return Limits::min();
  return static_cast<To>(value);
}

}  // namespace sheaf

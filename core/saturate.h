// Numbers from outside made integers without overflow.
#pragma once

#include <limits>
#include <type_traits>

namespace sheaf {

/// The value without its fraction; beyond the range of To the nearest end of it, and 0 for NaN. Round it first where
/// that is wanted. Casts of such values are undefined otherwise.
template <class To> constexpr To saturate(double value) {
  static_assert(std::is_integral_v<To>);
  using Limits = std::numeric_limits<To>;
  if (value != value) return 0;
  // The largest integers of 64 bits have no double of their own: the next one is a power of two.
  if (value >= static_cast<double>(Limits::max())) return Limits::max();
  if (value <= static_cast<double>(Limits::min())) return Limits::min();
  return static_cast<To>(value);
}

}  // namespace sheaf

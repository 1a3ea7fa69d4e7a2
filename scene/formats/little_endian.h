// Little-endian numbers in binary files.
#pragma once

#include <concepts>
#include <cstddef>

namespace sheaf {

/// Returns the number in sizeof(T) bytes, least significant byte first.
template <std::unsigned_integral T> T little_endian(const char* bytes) {
  T value = 0;
  for (std::size_t i = sizeof(T); i-- > 0;) value = static_cast<T>(value << 8 | static_cast<unsigned char>(bytes[i]));
  return value;
}

}  // namespace sheaf

// doctest's CAPTURE for structured bindings. CAPTURE uses a lambda, which cannot capture structured bindings before
// Clang 16.
#pragma once

#include <doctest/doctest.h>

#include <string>
#include <type_traits>

namespace sheaf {

/// A value as messages print it: strings as text, enumerations as numbers.
template <class T> auto displayed(const T& value) {
  if constexpr (std::is_convertible_v<T, const char*>)
    return std::string(value);
  else if constexpr (std::is_enum_v<T>)
    return static_cast<int>(value);
  else
    return value;
}

}  // namespace sheaf

/// Reports the value of the structured binding `name` with each failure until the end of the scope.
#define CAPTURE_BINDING(name)                            \
  const auto captured_##name = ::sheaf::displayed(name); \
  INFO(#name " := ", captured_##name)

// Arrays of numbers, which programs that embed Sheaf pass as values of parameters. Files have no arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// An array in C order that another object owns.
struct ArrayValue {
  enum class Type { kFloat, kIndex, kByte };  ///< float, std::uint32_t, std::uint8_t

  Type type = Type::kFloat;
  std::vector<std::size_t> shape;
  const void* data = nullptr;              ///< size() numbers of the type
  std::shared_ptr<const void> owner = {};  ///< keeps `data` alive

  std::size_t size() const {
    std::size_t count = 1;
    for (const std::size_t side : shape) count *= side;
    return count;
  }
  /// The numbers of an array of kFloat, kIndex and kByte.
  std::span<const float> floats() const { return {static_cast<const float*>(data), size()}; }
  std::span<const std::uint32_t> indices() const { return {static_cast<const std::uint32_t*>(data), size()}; }
  std::span<const std::uint8_t> bytes() const { return {static_cast<const std::uint8_t*>(data), size()}; }
  /// "float32 (3, 2)", for messages.
  std::string text() const;
};

}  // namespace sheaf

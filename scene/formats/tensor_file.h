// Tensor files: named arrays of numbers of any dimension, in which the RGL material database keeps its measurements.
#pragma once

#include "core/error.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// "tensor_file" and a zero byte, two bytes for the version 1.0, then in little endian a uint32 for the number of
/// fields and for each: uint16 length and characters of its name, uint16 number of dimensions, a byte for the type (1
/// to 8: unsigned and signed integers of 1, 2, 4 and 8 bytes in turn; 9 to 11: floats of 2, 4 and 8 bytes), uint64 for
/// where in the file its numbers begin, and a uint64 for each dimension, the slowest first.
class TensorFile {
 public:
  enum class Type : std::uint8_t { kUint8 = 1, kFloat32 = 10 };
  /// Dimensions of a field; no more than kMaxDimensions.
  using Shape = std::vector<std::uint64_t>;
  static constexpr std::size_t kMaxDimensions = 16, kMaxFields = 1024;

  /// Throws SceneError for files that are missing, truncated or no tensor files, and for fields that lie outside.
  explicit TensorFile(const std::filesystem::path& file);

  bool has(const std::string& name) const { return fields_.contains(name); }
  /// The dimensions of a field, of which there must be `dimensions`. Throws SceneError for others, and where there is
  /// no such field.
  const Shape& shape(const std::string& name, std::size_t dimensions) const;
  /// The numbers of a field of 32-bit floats, which must be finite. Throws SceneError.
  std::vector<float> floats(const std::string& name) const;
  /// The bytes of a field of bytes. Throws SceneError.
  std::span<const char> bytes(const std::string& name) const;

  /// Throws SceneError at the file.
  [[noreturn]] void fail(const std::string& message) const { throw SceneError({name_}, message); }

 private:
  struct Field {
    std::uint8_t type = 0;
    std::uint64_t offset = 0, count = 0;
    Shape shape;
  };

  class Reader;
  const Field& field(const std::string& name) const;
  const Field& field(const std::string& name, Type type) const;

  std::string name_, content_;
  std::map<std::string, Field> fields_;
};

/// "2 x 3 x 4".
std::string to_string(const TensorFile::Shape& shape);

}  // namespace sheaf

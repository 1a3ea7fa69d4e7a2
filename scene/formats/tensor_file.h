// Tensor files: named multidimensional arrays of numbers, the format of the RGL material database.
#pragma once

#include "core/io/error.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// Reader of tensor files. A file starts with "tensor_file" and a zero byte, two bytes for the version 1.0, and a
/// little-endian uint32 number of fields. Each field consists of:
///   - uint16 length and characters of its name,
///   - uint16 number of dimensions,
///   - a byte for the type (1 to 8: alternating unsigned and signed integers of 1, 2, 4 and 8 bytes; 9 to 11: floats of
///     2, 4 and 8 bytes),
///   - uint64 file offset of its numbers,
///   - a uint64 per dimension, the slowest first.
class TensorFile {
 public:
  enum class Type : std::uint8_t { kUint8 = 1, kUint16 = 3, kFloat32 = 10 };
  /// Dimensions of a field; at most kMaxDimensions.
  using Shape = std::vector<std::uint64_t>;
  static constexpr std::size_t kMaxDimensions = 16, kMaxFields = 1024;

  /// Throws SceneError for files that are missing, truncated or not tensor files, and for fields that reach beyond the
  /// file.
  explicit TensorFile(const std::filesystem::path& file);

  bool has(const std::string& name) const { return fields_.contains(name); }
  /// Returns the shape of a field with `dimensions` dimensions. Throws SceneError for another number of dimensions and
  /// for an unknown field.
  const Shape& shape(const std::string& name, std::size_t dimensions) const;
  /// Returns the numbers of a float32 field, all finite. Throws SceneError.
  std::vector<float> floats(const std::string& name) const;
  /// Returns the numbers 0, n, 2 n, ... of a float32 field, which need not be finite. Throws SceneError.
  std::vector<float> every_nth_float(const std::string& name, std::size_t n) const;
  /// Returns the numbers of a uint16 field. Throws SceneError.
  std::vector<std::uint16_t> shorts(const std::string& name) const;
  /// Returns the bytes of a uint8 field. Throws SceneError.
  std::span<const char> bytes(const std::string& name) const;

  /// Throws SceneError located at the file.
  [[noreturn]] void fail(const std::string& message) const { throw SceneError(SourceLocation{name_}, message); }

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

/// Formats a shape as "2 x 3 x 4".
std::string to_string(const TensorFile::Shape& shape);

}  // namespace sheaf

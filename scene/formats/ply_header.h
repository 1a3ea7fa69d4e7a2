// PLY headers: encoding and elements of the file's body.
#pragma once

#include "core/io/error.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Number types of PLY.
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Bytes per number in a binary file.
std::size_t ply_type_size(PlyType type);

/// One number per row of an element, or a list of numbers.
struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type;  ///< of lists: integer type of the preceding length
};

/// A table of rows with the same properties.
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  ///< number of rows; checked against the file size
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Encoding { kAscii, kLittleEndian, kBigEndian } encoding = Encoding::kAscii;
  std::vector<PlyElement> elements;
  std::string texture;   ///< NAME in MeshLab's line "comment TextureFile NAME"; may be empty
  std::size_t size = 0;  ///< bytes before the body
  int lines = 0;         ///< lines before the body
};

/// Parses the header of a file with content `bytes`. Throws SceneError with the line of the error, also for elements
/// with more rows than the rest of the file can hold. `file_bytes`: size of the file if `bytes` are only its beginning.
PlyHeader parse_ply_header(std::string_view bytes, const std::string& file, std::uint64_t file_bytes = 0);

}  // namespace sheaf

// The header of a PLY file: which elements the body holds, in which encoding.
#pragma once

#include "core/error.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// The number types of PLY.
enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Bytes per number in a binary file.
std::size_t ply_type_size(PlyType type);

/// One number per row of an element, or a list of numbers.
struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type;  ///< of lists: the integer type of the length in front
};

/// A table: rows with the same properties.
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  ///< rows; as the file claims, but not more than its size allows
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Encoding { kAscii, kLittleEndian, kBigEndian } encoding = Encoding::kAscii;
  std::vector<PlyElement> elements;
  std::string texture;   ///< NAME of the line "comment TextureFile NAME", as MeshLab writes it; may be empty
  std::size_t size = 0;  ///< bytes in front of the body
  int lines = 0;         ///< lines in front of the body
};

/// Reads the header of the file whose content is `bytes`. Throws SceneError with the line of what is wrong, also where
/// an element has more rows than the rest of the file can hold.
PlyHeader parse_ply_header(std::string_view bytes, const std::string& file);

}  // namespace sheaf

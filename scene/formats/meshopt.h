// Buffers compressed by meshoptimizer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// Compression of a buffer view, with the names of EXT_meshopt_compression.
struct MeshoptCompression {
  std::size_t count = 0, stride = 0;  ///< elements, and bytes of each
  std::string mode;                   ///< "ATTRIBUTES", "TRIANGLES" or "INDICES"
  std::string filter = "NONE";        ///< "NONE", "OCTAHEDRAL", "QUATERNION" or "EXPONENTIAL"
};

/// Returns the count * stride decompressed bytes; nothing if the data or the parameters are invalid. Throws Error if
/// Sheaf was built without the library, or if there is too little memory.
std::optional<std::vector<std::uint8_t>> decode_meshopt(const MeshoptCompression& compression,
                                                        std::span<const std::uint8_t> bytes);

}  // namespace sheaf

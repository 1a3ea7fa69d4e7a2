// Meshes compressed by Draco.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// A decompressed mesh.
struct DracoMesh {
  struct Attribute {
    int components = 0;
    std::vector<float> values;   ///< `components` per vertex
    bool is_normalized = false;  ///< integers have been converted to [0, 1] or [-1, 1]
  };
  std::map<std::string, Attribute> attributes;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices in range
};

/// Decompresses the attributes with the given ids in the compressed mesh. Returns nothing if the data is invalid or
/// lacks one of them. Throws Error if Sheaf was built without the library.
std::optional<DracoMesh> decode_draco(std::span<const std::uint8_t> bytes, const std::map<std::string, int>& ids);

}  // namespace sheaf

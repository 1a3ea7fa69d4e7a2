// Buffers compressed by meshoptimizer (library meshoptimizer).
#include "scene/formats/meshopt.h"

#include "core/io/error.h"
#include "core/io/memory.h"

#ifdef SHEAF_HAS_MESHOPT
#include <meshoptimizer.h>
#endif

namespace sheaf {

#ifdef SHEAF_HAS_MESHOPT

namespace {

bool decode(const MeshoptCompression& c, std::span<const std::uint8_t> in, std::vector<std::uint8_t>& out) {
  if (c.mode == "ATTRIBUTES")
    return meshopt_decodeVertexBuffer(out.data(), c.count, c.stride, in.data(), in.size()) == 0;
  if (c.stride != 2 && c.stride != 4) return false;
  if (c.mode == "TRIANGLES")
    return c.count % 3 == 0 && meshopt_decodeIndexBuffer(out.data(), c.count, c.stride, in.data(), in.size()) == 0;
  return c.mode == "INDICES" && meshopt_decodeIndexSequence(out.data(), c.count, c.stride, in.data(), in.size()) == 0;
}

bool apply_filter(const MeshoptCompression& c, std::vector<std::uint8_t>& bytes) {
  if (c.filter == "NONE") return true;
  if (c.mode != "ATTRIBUTES") return false;
  if (c.filter == "OCTAHEDRAL") {
    if (c.stride != 4 && c.stride != 8) return false;
    meshopt_decodeFilterOct(bytes.data(), c.count, c.stride);
  } else if (c.filter == "QUATERNION") {
    if (c.stride != 8) return false;
    meshopt_decodeFilterQuat(bytes.data(), c.count, c.stride);
  } else if (c.filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(bytes.data(), c.count, c.stride);
  } else {
    return false;
  }
  return true;
}

}  // namespace

std::optional<std::vector<std::uint8_t>> decode_meshopt(const MeshoptCompression& compression,
                                                        std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMaxStride = 256;
  const std::size_t stride = compression.stride;
  if (stride == 0 || stride > kMaxStride || (compression.mode == "ATTRIBUTES" && stride % 4 != 0)) return std::nullopt;
  // A block of at most 256 elements takes a byte or more.
  if (compression.count == 0 || compression.count / kMaxStride > bytes.size()) return std::nullopt;
  const MemoryUse use{"the buffer", static_cast<double>(compression.count) * static_cast<double>(stride), ""};
  check_memory("a compressed buffer", {&use, 1});
  std::vector<std::uint8_t> decoded(compression.count * stride);
  if (!decode(compression, bytes, decoded) || !apply_filter(compression, decoded)) return std::nullopt;
  return decoded;
}

#else

std::optional<std::vector<std::uint8_t>> decode_meshopt(const MeshoptCompression&, std::span<const std::uint8_t>) {
  throw SceneError("this build of Sheaf cannot read EXT_meshopt_compression: it was built without meshoptimizer");
}

#endif

}  // namespace sheaf

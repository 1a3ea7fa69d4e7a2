// File layout, all numbers little endian: the meshes in sequence, then the offset of each mesh and their number. A mesh
// is a magic number, a version and a zlib stream of flags, name, counts and arrays.
#include "scene/formats/serialized.h"

#include "core/io/inflate.h"
#include "scene/formats/little_endian.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstring>
#include <limits>

namespace sheaf {

namespace {

constexpr std::uint16_t kSerializedMagic = 0x041c;
constexpr std::uint16_t kVersion3 = 3;  ///< no name; 32-bit offsets in the directory
constexpr std::uint16_t kVersion4 = 4;

enum Flag : std::uint32_t {
  kFileHasNormals = 0x0001,
  kFileHasUvs = 0x0002,
  kFileHasColors = 0x0008,
  kFaceNormals = 0x0010,
  kDoublePrecision = 0x2000,
};

std::string plural(std::uint64_t count, const char* what) { return fmt::format("{} {}", count, what); }

/// Directory of the meshes in a file.
class ObjectDirectory {
 public:
  ObjectDirectory(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  /// Returns the data of a mesh from its header to the directory; mesh 0 extends to the end of the file.
  std::string_view find(int index) const {
    const std::uint16_t version = check_header(0);
    if (index == 0) return bytes_;
    const std::uint64_t width = version == kVersion4 ? 8 : 4, count_size = 4;
    if (bytes_.size() < kHeaderSize + count_size) fail("the file is truncated");
    const std::uint64_t count = little_endian<std::uint32_t>(bytes_.data() + bytes_.size() - count_size);
    const std::uint64_t room = bytes_.size() - kHeaderSize - count_size;
    if (count > room / width) {
      fail(fmt::format("the file claims to hold {}, more than its size allows: truncated?", plural(count, "meshes")));
    }
    if (index < 0 || static_cast<std::uint64_t>(index) >= count) {
      fail(fmt::format("no mesh {} (counted from 0), the file holds {}", index, plural(count, "meshes")));
    }
    const std::uint64_t end = bytes_.size() - count_size - count * width;
    const char* const entry = bytes_.data() + end + static_cast<std::uint64_t>(index) * width;
    const std::uint64_t offset =
        version == kVersion4 ? little_endian<std::uint64_t>(entry) : little_endian<std::uint32_t>(entry);
    if (end < kHeaderSize || offset > end - kHeaderSize)
      fail(fmt::format("mesh {} begins beyond the end of the file", index));
    check_header(offset);
    return bytes_.substr(offset, end - offset);
  }

  static constexpr std::uint64_t kHeaderSize = 4;

 private:
  [[noreturn]] void fail(const std::string& message) const { throw SceneError(SourceLocation{file_}, message); }

  std::uint16_t check_header(std::uint64_t offset) const {
    if (bytes_.size() - offset < kHeaderSize ||
        little_endian<std::uint16_t>(bytes_.data() + offset) != kSerializedMagic) {
      fail("expected a serialized mesh, which begins with the bytes 1c 04" +
           (offset > 0 ? fmt::format(", at byte {}", offset) : std::string()));
    }
    const auto version = little_endian<std::uint16_t>(bytes_.data() + offset + 2);
    if (version != kVersion3 && version != kVersion4) {
      fail(fmt::format("expected version 3 or 4 of the serialized format, found {}", version));
    }
    return version;
  }

  std::string_view bytes_;
  const std::string& file_;
};

/// The decompressed data of a mesh.
class MeshStream {
 public:
  MeshStream(std::string_view deflated, const std::string& file) : inflater_(deflated), file_(file) {}

  template <std::unsigned_integral T> T number() {
    std::array<char, sizeof(T)> raw;
    read(raw);
    return little_endian<T>(raw.data());
  }

  void skip_name() {
    constexpr int kLongestName = 65536;
    int length = 0;
    while (number<std::uint8_t>() != 0) {
      if (++length > kLongestName) fail("the mesh's name does not end");
    }
  }

  /// Throws unless `count` rows of `row_size` bytes can follow.
  void require(std::uint64_t count, std::uint64_t row_size, const char* what) const {
    if (count > std::numeric_limits<std::uint32_t>::max()) fail("a mesh of more than 2^32 - 1 " + std::string(what));
    if (count * row_size <= inflater_.max_remaining()) return;
    fail(fmt::format("the mesh claims {}, more than the file's size allows: truncated?", plural(count, what)));
  }

  /// Reads `count` values in the file's precision.
  std::vector<float> floats(std::uint64_t count, bool is_double) {
    std::vector<float> values(count);
    std::array<char, 8192> raw;
    const std::size_t width = is_double ? 8 : 4;
    for (std::uint64_t begin = 0; begin < count;) {
      const std::size_t rows = static_cast<std::size_t>(std::min<std::uint64_t>(raw.size() / width, count - begin));
      read(std::span(raw).first(rows * width));
      for (std::size_t i = 0; i < rows; ++i) {
        const char* const at = raw.data() + i * width;
        values[begin + i] = is_double ? static_cast<float>(std::bit_cast<double>(little_endian<std::uint64_t>(at)))
                                      : std::bit_cast<float>(little_endian<std::uint32_t>(at));
      }
      begin += rows;
    }
    return values;
  }

  [[noreturn]] void fail(const std::string& message) const { throw SceneError(SourceLocation{file_}, message); }

 private:
  void read(std::span<char> out) {
    std::size_t found = 0;
    try {
      found = inflater_.read(out);
    } catch (const Error& error) { fail(error.what()); }
    if (found < out.size()) fail("the file is truncated");
  }

  Inflater inflater_;
  const std::string& file_;
};

std::vector<Vec3f> to_vectors(const std::vector<float>& values) {
  std::vector<Vec3f> vectors(values.size() / 3);
  for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  return vectors;
}

void read_triangles(MeshStream& stream, std::uint64_t vertices, std::uint64_t triangles, BadFaces bad_faces,
                    MeshFile& file) {
  Mesh& mesh = file.mesh;
  mesh.triangles.resize(triangles);
  std::string first_bad;
  for (std::uint64_t i = 0; i < triangles; ++i) {
    for (std::uint32_t& vertex : mesh.triangles[i]) {
      vertex = stream.number<std::uint32_t>();
      if (vertex < vertices) continue;
      if (first_bad.empty())
        first_bad =
            fmt::format("triangle {} refers to vertex {} (counted from 0), but there are {}", i, vertex, vertices);
      if (bad_faces == BadFaces::kError) stream.fail(first_bad);
    }
  }
  const std::size_t dropped = std::erase_if(mesh.triangles, [vertices](const std::array<std::uint32_t, 3>& t) {
    return t[0] >= vertices || t[1] >= vertices || t[2] >= vertices;
  });
  if (mesh.triangles.empty()) stream.fail("no triangle is complete: " + first_bad);
  if (dropped > 0) file.warnings.push_back(fmt::format("faces left out: {} ({})", dropped, first_bad));
}

MeshFile read_stream(MeshStream& stream, std::uint16_t version, BadFaces bad_faces) {
  MeshFile result;
  Mesh& mesh = result.mesh;
  const auto flags = stream.number<std::uint32_t>();
  if (version == kVersion4) stream.skip_name();
  const auto vertices = stream.number<std::uint64_t>(), triangles = stream.number<std::uint64_t>();
  const bool is_double = (flags & kDoublePrecision) != 0;
  const auto columns = [&](Flag flag, std::uint64_t count) { return (flags & flag) != 0 ? count : 0; };
  const std::uint64_t floats = 3 + columns(kFileHasNormals, 3) + columns(kFileHasUvs, 2) + columns(kFileHasColors, 3);
  stream.require(vertices, floats * (is_double ? 8 : 4), "vertices");
  stream.require(triangles, 12, "triangles");
  if (triangles == 0) stream.fail("the mesh holds no triangles");
  // Read the vertex arrays
  mesh.positions = to_vectors(stream.floats(vertices * 3, is_double));
  if ((flags & kFileHasNormals) != 0) {
    mesh.normals = to_vectors(stream.floats(vertices * 3, is_double));
    for (Vec3f& n : mesh.normals) n = is_finite(n) ? n : Vec3f{0, 0, 0};
  }
  if ((flags & kFileHasUvs) != 0) {
    const std::vector<float> values = stream.floats(vertices * 2, is_double);
    mesh.uvs.resize(vertices);
    for (std::size_t i = 0; i < vertices; ++i) {
      const bool is_uv = std::isfinite(values[2 * i]) && std::isfinite(values[2 * i + 1]);
      mesh.uvs[i] = is_uv ? Vec2f{values[2 * i], values[2 * i + 1]} : Vec2f{0, 0};
    }
  }
  if ((flags & kFileHasColors) != 0) {
    mesh.attributes.push_back({"vertex_color", 3, stream.floats(vertices * 3, is_double)});
    for (float& value : mesh.attributes[0].values) value = std::isfinite(value) ? value : 0.0f;
  }
  read_triangles(stream, vertices, triangles, bad_faces, result);
  result.face_normals = (flags & kFaceNormals) != 0;
  return result;
}

}  // namespace

MeshFile read_serialized(const std::filesystem::path& file, int shape_index, BadFaces bad_faces) {
  const std::string name = file.string();
  const std::string bytes = read_mesh_bytes(file, "serialized mesh");
  const std::string_view found = ObjectDirectory(bytes, name).find(shape_index);
  MeshStream stream(found.substr(ObjectDirectory::kHeaderSize), name);
  return read_stream(stream, little_endian<std::uint16_t>(found.data() + 2), bad_faces);
}

}  // namespace sheaf

#include "scene/formats/plain_ply.h"

#include "core/io/parallel_ranges.h"
#include "core/soa/large_pages.h"
#include "scene/formats/ply_attributes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <span>
#include <string>
#include <system_error>
#include <vector>

namespace sheaf {

namespace {

constexpr std::size_t kRowsPerRead = std::size_t{1} << 15;
constexpr std::size_t kTriangleRow = 1 + 3 * sizeof(std::uint32_t);  // the number of corners and the corners

/// Reads `bytes` from a position of a file. Returns false if that fails.
bool read_at(const std::filesystem::path& file, std::uint64_t position, std::span<char> bytes) {
  std::ifstream stream;
  stream.rdbuf()->pubsetbuf(nullptr, 0);
  stream.open(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(position));
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return stream.gcount() == static_cast<std::streamsize>(bytes.size());
}

/// Calls use(first row, row count, bytes) for ranges of `count` rows of `row_bytes`, by all threads, until one returns
/// false. Returns whether all rows could be read and used.
template <class Use>
bool for_rows(const std::filesystem::path& file, std::uint64_t position, std::size_t count, std::size_t row_bytes,
              const Use& use) {
  std::atomic<bool> good{true};
  parallel_ranges(
      count,
      [&](std::size_t begin, std::size_t end) {
        std::vector<char> bytes(std::min(kRowsPerRead, end - begin) * row_bytes);
        for (std::size_t row = begin; row < end && good; row += kRowsPerRead) {
          const std::size_t rows = std::min(kRowsPerRead, end - row);
          const std::span<char> read(bytes.data(), rows * row_bytes);
          if (!read_at(file, position + row * row_bytes, read) || !use(row, rows, read.data())) good = false;
        }
      },
      kRowsPerRead);
  return good;
}

/// The slots of the properties of vertices; empty for other layouts.
std::vector<PlySlot> vertex_slots(const PlyElement& element) {
  std::vector<PlySlot> slots;
  for (const PlyProperty& property : element.properties) {
    const auto slot = ply_slot(property);
    if (!slot || property.type != PlyType::kFloat32) return {};
    slots.push_back(*slot);
  }
  return slots;
}

bool is_list_of_corners(const PlyElement& element) {
  if (element.name != "face" || element.properties.size() != 1) return false;
  const PlyProperty& list = element.properties.front();
  const bool has_name = list.name == "vertex_indices" || list.name == "vertex_index";
  const bool has_bytes = list.count_type && ply_type_size(*list.count_type) == 1;
  return has_name && has_bytes && (list.type == PlyType::kInt32 || list.type == PlyType::kUint32);
}

bool has_slot(const std::vector<PlySlot>& slots, PlySlot slot) {
  return std::find(slots.begin(), slots.end(), slot) != slots.end();
}

template <class T> void resize_rows(std::vector<T>& rows, std::size_t count) {
  rows.reserve(count);
  prepare_pages(rows.data(), count * sizeof(T));
  rows.resize(count);
}

bool read_vertices(const std::filesystem::path& file, std::uint64_t position, std::size_t count,
                   const std::vector<PlySlot>& slots, Mesh& mesh) {
  const auto has = [&](PlySlot a, PlySlot b) { return has_slot(slots, a) && has_slot(slots, b); };
  const bool has_normals = has(kPlyNormalX, kPlyNormalY) && has_slot(slots, kPlyNormalZ);
  const bool has_uvs = has(kPlyU, kPlyV);
  if (!has(kPlyX, kPlyY) || !has_slot(slots, kPlyZ)) return false;
  resize_rows(mesh.positions, count);
  if (has_normals) resize_rows(mesh.normals, count);
  if (has_uvs) resize_rows(mesh.uvs, count);
  return for_rows(file, position, count, slots.size() * sizeof(float),
                  [&](std::size_t first, std::size_t rows, const char* bytes) {
                    std::array<float, kPlySlots> v{};
                    for (std::size_t i = first; i < first + rows; ++i) {
                      for (const PlySlot slot : slots) {
                        std::memcpy(&v[slot], bytes, sizeof(float));
                        bytes += sizeof(float);
                      }
                      mesh.positions[i] = {v[kPlyX], v[kPlyY], v[kPlyZ]};
                      const Vec3f normal{v[kPlyNormalX], v[kPlyNormalY], v[kPlyNormalZ]};
                      if (has_normals) mesh.normals[i] = is_finite(normal) ? normal : Vec3f{0, 0, 0};
                      const bool is_uv = std::isfinite(v[kPlyU]) && std::isfinite(v[kPlyV]);
                      if (has_uvs) mesh.uvs[i] = is_uv ? Vec2f{v[kPlyU], v[kPlyV]} : Vec2f{0, 0};
                    }
                    return true;
                  });
}

bool read_triangles(const std::filesystem::path& file, std::uint64_t position, std::size_t count, Mesh& mesh) {
  const std::size_t vertices = mesh.positions.size();
  resize_rows(mesh.triangles, count);
  return for_rows(file, position, count, kTriangleRow, [&](std::size_t first, std::size_t rows, const char* bytes) {
    for (std::size_t i = first; i < first + rows; ++i, bytes += kTriangleRow) {
      std::array<std::uint32_t, 3>& triangle = mesh.triangles[i];
      std::memcpy(triangle.data(), bytes + 1, sizeof(triangle));
      if (bytes[0] != 3 || std::max({triangle[0], triangle[1], triangle[2]}) >= vertices) return false;
    }
    return true;
  });
}

/// The header, if the beginning of the file holds it. Throws SceneError.
PlyHeader read_header(const std::filesystem::path& file, std::uint64_t file_bytes) {
  std::string beginning(std::size_t{1} << 16, '\0');
  if (file_bytes < beginning.size() || !read_at(file, 0, beginning))
    throw SceneError(SourceLocation{file.string()}, "cannot be read");
  return parse_ply_header(beginning, file.string(), file_bytes);
}

}  // namespace

std::optional<MeshFile> read_plain_ply(const std::filesystem::path& file, bool flip_tex_coords) {
  constexpr std::uint64_t kMinBytes = std::uint64_t{1} << 20;
  constexpr std::uint64_t kMaxVertices = std::numeric_limits<std::int32_t>::max();
  std::error_code failure;
  if (!std::filesystem::is_regular_file(file, failure) || file.extension() == ".gz") return {};
  const std::uint64_t size = std::filesystem::file_size(file, failure);
  if (failure || size < kMinBytes || std::endian::native != std::endian::little) return {};
  // Check the layout
  PlyHeader header;
  try {
    header = read_header(file, size);
  } catch (const SceneError&) {
    return {};  // read again by the reader that reports errors
  }
  const bool has_elements = header.elements.size() == 2 && header.elements[0].name == "vertex";
  if (!has_elements || header.encoding != PlyHeader::Encoding::kLittleEndian) return {};
  const PlyElement &vertices = header.elements[0], &faces = header.elements[1];
  const std::vector<PlySlot> slots = vertex_slots(vertices);
  const bool is_plain = !slots.empty() && is_list_of_corners(faces) && vertices.count > 0 && faces.count > 0;
  if (!is_plain || vertices.count > kMaxVertices || vertices.count + 3 * faces.count >= 2 * kMaxVertices) return {};
  const std::uint64_t vertex_bytes = vertices.count * slots.size() * sizeof(float);
  if (header.size + vertex_bytes + faces.count * kTriangleRow > size) return {};
  // Read it
  MeshFile result;
  if (!read_vertices(file, header.size, vertices.count, slots, result.mesh)) return {};
  if (!read_triangles(file, header.size + vertex_bytes, faces.count, result.mesh)) return {};
  if (flip_tex_coords)
    for (Vec2f& uv : result.mesh.uvs) uv.y = 1 - uv.y;
  result.texture = header.texture;
  return result;
}

}  // namespace sheaf

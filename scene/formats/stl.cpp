// STL meshes: lists of triangles without shared vertices.
#include "scene/formats/stl.h"

#include "scene/formats/little_endian.h"

#include <bit>
#include <charconv>
#include <unordered_map>

namespace sheaf {

namespace {

constexpr std::size_t kHeader = 84, kTriangle = 50;  ///< bytes of the binary format

/// Collects triangles, and merges equal vertices.
class TriangleList {
 public:
  void add(Vec3f p) {
    const Key key{std::bit_cast<std::uint32_t>(p.x + 0.0f), std::bit_cast<std::uint32_t>(p.y + 0.0f),
                  std::bit_cast<std::uint32_t>(p.z + 0.0f)};
    const auto [found, is_new] = vertices_.try_emplace(key, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (is_new) mesh_.positions.push_back(p);
    corners_[count_++] = found->second;
    if (count_ < 3) return;
    mesh_.triangles.push_back(corners_);
    count_ = 0;
  }
  bool is_complete() const { return count_ == 0; }
  Mesh take() { return std::move(mesh_); }

 private:
  using Key = std::array<std::uint32_t, 3>;
  struct Hash {
    std::size_t operator()(const Key& key) const {
      std::uint64_t h = 0;
      for (const std::uint32_t word : key) h = (h ^ word) * 0x9e3779b97f4a7c15u, h ^= h >> 29;
      return static_cast<std::size_t>(h);
    }
  };
  Mesh mesh_;
  std::unordered_map<Key, std::uint32_t, Hash> vertices_;
  std::array<std::uint32_t, 3> corners_{};
  std::size_t count_ = 0;
};

bool is_binary(const std::string& bytes) {
  if (bytes.size() < kHeader) return false;
  const std::size_t triangles = little_endian<std::uint32_t>(bytes.data() + kHeader - 4);
  return triangles <= (bytes.size() - kHeader) / kTriangle && !(bytes.starts_with("solid") && triangles == 0);
}

void read_binary(const std::string& bytes, TriangleList& out) {
  const std::size_t triangles = little_endian<std::uint32_t>(bytes.data() + kHeader - 4);
  const auto number = [&](std::size_t at) {
    return std::bit_cast<float>(little_endian<std::uint32_t>(bytes.data() + at));
  };
  for (std::size_t i = 0; i < triangles; ++i)
    for (std::size_t corner = 1; corner <= 3; ++corner) {
      const std::size_t at = kHeader + i * kTriangle + corner * 12;
      out.add({number(at), number(at + 4), number(at + 8)});
    }
}

/// The words of a text, with their lines.
class Words {
 public:
  Words(const std::string& text, const std::filesystem::path& file) : text_(text), file_(file) {}

  /// The next word; empty at the end.
  std::string_view next() {
    while (at_ < text_.size() && is_blank(text_[at_])) {
      if (text_[at_] == '\n') ++line_;
      ++at_;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
    return std::string_view(text_).substr(begin, at_ - begin);
  }
  float number() {
    const std::string_view word = next();
    float value = 0;
    const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || result.ec != std::errc() || result.ptr != word.data() + word.size())
      throw SceneError({file_.string(), line_}, in_quotes(word) + " is not a number");
    return value;
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  const std::string& text_;
  const std::filesystem::path& file_;
  std::size_t at_ = 0;
  int line_ = 1;
};

void read_ascii(const std::string& text, const std::filesystem::path& file, TriangleList& out) {
  Words words(text, file);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word != "vertex") continue;
    const float x = words.number(), y = words.number(), z = words.number();
    out.add({x, y, z});
  }
}

}  // namespace

MeshFile read_stl(const std::filesystem::path& file) {
  const std::string bytes = read_mesh_bytes(file, "STL file");
  TriangleList triangles;
  if (is_binary(bytes)) {
    read_binary(bytes, triangles);
  } else if (bytes.starts_with("solid")) {
    read_ascii(bytes, file, triangles);
  } else {
    throw SceneError({file.string(), 0}, "is neither a binary nor an ASCII STL file, or it is truncated");
  }
  if (!triangles.is_complete()) throw SceneError({file.string(), 0}, "ends inside a triangle");
  MeshFile out;
  out.mesh = triangles.take();
  if (out.mesh.triangles.empty()) throw SceneError({file.string(), 0}, "has no triangles");
  return out;
}

}  // namespace sheaf

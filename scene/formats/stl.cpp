// STL meshes: lists of triangles without shared vertices.
#include "scene/formats/stl.h"

#include "core/io/byte_order_mark.h"
#include "scene/formats/little_endian.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

namespace sheaf {

namespace {

constexpr std::size_t kHeader = 84, kTriangle = 50;  ///< bytes of the binary format
constexpr std::string_view kWhiteSpace = " \t\r\n\v\f";

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

/// Number of triangles that the header of a binary file announces. `bytes`: at least kHeader.
std::size_t announced_triangles(const std::string& bytes) {
  return little_endian<std::uint32_t>(bytes.data() + kHeader - 4);
}

bool equal_words(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [&](char x, char y) { return lower(x) == lower(y); });
}

/// Whether the first word is `solid`, in any case. Headers of binary files may begin so as well.
bool begins_with_solid(std::string_view bytes) {
  constexpr std::string_view kSolid = "solid";
  bytes.remove_prefix(std::min(bytes.find_first_not_of(kWhiteSpace), bytes.size()));
  return equal_words(bytes.substr(0, kSolid.size()), kSolid);
}

/// Whether all triangles of the header are there.
bool is_binary(const std::string& bytes) {
  if (bytes.size() < kHeader) return false;
  const std::size_t triangles = announced_triangles(bytes);
  return triangles <= (bytes.size() - kHeader) / kTriangle && !(begins_with_solid(bytes) && triangles == 0);
}

/// Whether the bytes of a header and of the first triangle are characters of a text: binary files have zeros there.
bool is_text(const std::string& bytes) {
  return std::string_view(bytes).substr(0, kHeader + kTriangle).find('\0') == std::string_view::npos;
}

void read_binary(const std::string& bytes, TriangleList& out) {
  const std::size_t triangles = announced_triangles(bytes);
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
  /// Skips the name of a solid: the rest of the line, or the words before `facet normal` with three numbers and
  /// `outer`, which may follow in the same line.
  void skip_name() {
    for (;;) {
      const Words before = *this;
      const std::string_view word = next();
      if (word.empty() || line_ != before.line_) return go_to(before);
      if (!equal_words(word, "facet")) continue;
      const Words after = *this;
      if (begins_facet()) return go_to(before);
      go_to(after);
    }
  }
  float number() {
    const std::string_view word = next();
    if (word.empty()) fail("ends inside a triangle: the file is truncated");
    const std::optional<double> value = parse(word);
    if (!value) fail(in_quotes(word) + " is not a number");
    if (std::isfinite(*value) && std::abs(*value) > static_cast<double>(std::numeric_limits<float>::max()))
      fail(in_quotes(word) + " is too large for single precision");
    return static_cast<float>(*value);
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw SceneError(SourceLocation{file_.string(), line_}, message);
  }

 private:
  void go_to(const Words& other) {
    at_ = other.at_;
    line_ = other.line_;
  }
  static bool is_blank(char c) { return kWhiteSpace.find(c) != std::string_view::npos; }
  /// Whether the words after `facet` are `normal`, three numbers and `outer`.
  bool begins_facet() {
    if (!equal_words(next(), "normal")) return false;
    for (int i = 0; i < 3; ++i)
      if (!parse(next())) return false;
    return equal_words(next(), "outer");
  }
  /// Numbers that underflow are 0, those that overflow infinite.
  static std::optional<double> parse(std::string_view word) {
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    double value = 0;
    const char* const end = word.data() + word.size();
    const auto result = std::from_chars(word.data(), end, value);
    if (result.ptr != end || result.ec == std::errc::invalid_argument) return std::nullopt;
    if (result.ec == std::errc::result_out_of_range)
      return word.find("e-") != word.npos || word.find("E-") != word.npos ? 0.0 : std::numeric_limits<double>::max();
    return value;
  }

  const std::string& text_;
  const std::filesystem::path& file_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// Reads the facets of all solids. The normals of the file are ignored, as are unknown words.
void read_ascii(const std::string& text, const std::filesystem::path& file, TriangleList& out,
                std::vector<std::string>& warnings) {
  Words words(text, file);
  bool in_solid = false, in_facet = false;
  const auto check_facet = [&] {
    if (!out.is_complete()) words.fail("a facet does not have 3 vertices");
  };
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    const bool is_end = equal_words(word, "end");  // "end facet"
    if (is_end) word = words.next();
    if (equal_words(word, "vertex")) {
      const float x = words.number(), y = words.number(), z = words.number();
      out.add({x, y, z});
    } else if (equal_words(word, "facet") || equal_words(word, "endfacet")) {
      check_facet();
      in_facet = equal_words(word, "facet") && !is_end;
    } else if (equal_words(word, "solid") || equal_words(word, "endsolid")) {
      check_facet();
      in_solid = equal_words(word, "solid") && !is_end;
      in_facet = false;
      words.skip_name();
    }
  }
  if (in_facet || !out.is_complete()) words.fail("ends inside a triangle: the file is truncated");
  if (in_solid) warnings.emplace_back("ends without 'endsolid': it may be truncated");
}

}  // namespace

MeshFile read_stl(const std::filesystem::path& file) {
  std::string bytes = read_mesh_bytes(file, "STL file");
  const SourceLocation where{file.string()};
  MeshFile out;
  TriangleList triangles;
  if (is_binary(bytes)) {
    read_binary(bytes, triangles);
  } else {
    remove_byte_order_mark(bytes, file.string());
    if (begins_with_solid(bytes) && is_text(bytes)) {
      read_ascii(bytes, file, triangles, out.warnings);
    } else if (bytes.size() < kHeader) {
      throw SceneError(
          where, fmt::format("is not an STL file (ASCII files begin with 'solid', binary ones have at least {} bytes)",
                             kHeader));
    } else {
      const std::size_t announced = announced_triangles(bytes);
      throw SceneError(where, fmt::format("is a truncated binary STL file, or not an STL file: its header announces {} "
                                          "triangles ({} bytes), but the file has {} bytes",
                                          announced, kHeader + announced * kTriangle, bytes.size()));
    }
  }
  out.mesh = triangles.take();
  if (out.mesh.triangles.empty()) throw SceneError(where, "has no triangles");
  return out;
}

}  // namespace sheaf

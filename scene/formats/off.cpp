// OFF meshes: a header, a line per vertex, and a line per polygon with an optional colour.
#include "scene/formats/off.h"

#include "core/color/color.h"
#include "scene/formats/polygon.h"

#include <algorithm>
#include <charconv>
#include <span>

namespace sheaf {

namespace {

constexpr float kGrey = 0.6f;  ///< faces without a colour among others with one

/// The lines that are neither empty nor comments, as words.
class WordLines {
 public:
  WordLines(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  /// Advances to the next line; returns false at the end.
  bool next() {
    words_.clear();
    while (words_.empty() && !rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      split(rest_.substr(0, std::min(rest_.find('#'), end)));
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++line_;
    }
    return !words_.empty();
  }
  /// The words of the current line that are not taken yet.
  std::span<const std::string_view> words() const { return words_; }
  void take(std::size_t count) { words_.erase(words_.begin(), words_.begin() + static_cast<std::ptrdiff_t>(count)); }

  template <class T> T number(std::size_t i) const {
    if (i >= words_.size()) fail("the line has too few numbers");
    const std::string_view word = words_[i];
    const std::size_t sign = word.starts_with('+') && !word.starts_with("+-") ? 1 : 0;
    T value{};
    const auto result = std::from_chars(word.data() + sign, word.data() + word.size(), value);
    if (result.ec != std::errc() || result.ptr != word.data() + word.size())
      fail(in_quotes(word) + (std::is_integral_v<T> ? " is not an index or a count" : " is not a number"));
    return value;
  }
  [[noreturn]] void fail(const std::string& message) const { throw SceneError({file_, line_}, message); }

 private:
  void split(std::string_view line) {
    constexpr std::string_view kBlanks = " \t\r\v\f";
    for (;;) {
      line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
      if (line.empty()) return;
      const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
      words_.push_back(line.substr(0, end));
      line.remove_prefix(end);
    }
  }

  std::string_view rest_;
  const std::string& file_;
  std::vector<std::string_view> words_;
  int line_ = 0;
};

/// What a line of a vertex has besides the position.
struct VertexParts {
  bool normal = false, color = false, uv = false;
};

/// Colours of vertices or faces as they are in the file.
class Colors {
 public:
  /// Adds the first three of some numbers.
  void add(const WordLines& lines, std::size_t first) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value = lines.number<float>(first + k);
      has_bytes_ = has_bytes_ || value > 1;
      values_.push_back(value);
    }
    has_any_ = true;
  }
  void add_grey() { values_.insert(values_.end(), 3, kUnset); }

  bool has_any() const { return has_any_; }
  /// Linear colours.
  std::vector<float> take() {
    for (float& value : values_) {
      if (value == kUnset) {
        value = kGrey;
      } else if (has_bytes_) {
        value = srgb_to_linear(std::clamp(value / 255, 0.0f, 1.0f));
      } else if (!(value >= 0)) {
        value = 0;
      }
    }
    return std::move(values_);
  }

 private:
  static constexpr float kUnset = -1e30f;
  std::vector<float> values_;
  bool has_bytes_ = false, has_any_ = false;
};

class OffReader {
 public:
  OffReader(const std::string& text, const std::string& file, BadFaces bad_faces)
      : text_(text), file_(file), lines_(text, file_), bad_faces_(bad_faces) {}

  MeshFile read() {
    read_header();
    read_counts();
    for (std::size_t i = 0; i < vertices_; ++i) read_vertex();
    for (std::size_t i = 0; i < faces_; ++i) read_face();
    add_faces();
    return std::move(out_);
  }

 private:
  void advance(const char* what) {
    if (!lines_.next()) throw SceneError({file_, 0}, std::string("ends before ") + what);
  }

  /// Reads [ST][C][N]OFF, which may be absent.
  void read_header() {
    advance("its counts");
    std::string_view word = lines_.words().front();
    if (!word.ends_with("OFF")) return;
    const auto starts = [&](std::string_view prefix) {
      if (!word.starts_with(prefix)) return false;
      word.remove_prefix(prefix.size());
      return true;
    };
    parts_.uv = starts("ST");
    parts_.color = starts("C");
    parts_.normal = starts("N");
    if (word != "OFF") lines_.fail("has vertices of other than three dimensions, which Sheaf does not support");
    lines_.take(1);
    if (!lines_.words().empty() && lines_.words().front() == "BINARY")
      lines_.fail("is a binary OFF file, which Sheaf does not support; convert it to PLY");
    if (lines_.words().empty()) advance("its counts");
  }

  /// Reads the numbers of vertices, faces and, optionally, edges.
  void read_counts() {
    vertices_ = lines_.number<std::uint32_t>(0);
    faces_ = lines_.number<std::uint32_t>(1);
    // A vertex takes three digits with blanks, a face a digit.
    constexpr std::size_t kVertexBytes = 6;
    if (vertices_ > text_.size() / kVertexBytes + 1 || faces_ > text_.size())
      lines_.fail("the file is too small for " + std::to_string(vertices_) + " vertices and " + std::to_string(faces_) +
                  " faces");
    out_.mesh.positions.reserve(vertices_);
  }

  Vec3f vector(std::size_t first) const {
    return {lines_.number<float>(first), lines_.number<float>(first + 1), lines_.number<float>(first + 2)};
  }

  void read_vertex() {
    advance("all vertices");
    std::size_t at = 0;
    out_.mesh.positions.push_back(vector(at));
    at += 3;
    if (parts_.normal) out_.mesh.normals.push_back(vector(at)), at += 3;
    if (parts_.color) {
      vertex_colors_.add(lines_, at);
      // The coordinates of textures come last; alpha may precede them.
      at = parts_.uv ? std::max(at + 3, lines_.words().size() - 2) : at + 3;
    }
    if (parts_.uv) out_.mesh.uvs.push_back({lines_.number<float>(at), lines_.number<float>(at + 1)});
  }

  void read_face() {
    advance("all faces");
    const auto count = lines_.number<std::uint32_t>(0);
    if (count >= lines_.words().size()) lines_.fail("the face has fewer than " + std::to_string(count) + " vertices");
    if (count < 3) {
      ++polygons_.too_short;
      return;
    }
    for (std::uint32_t i = 1; i <= count; ++i) polygons_.corners.push_back(corner(i));
    polygons_.ends.push_back(polygons_.corners.size());
    // A single number is an index into a table of colours that is not part of the file.
    if (lines_.words().size() >= std::size_t{count} + 4) {
      face_colors_.add(lines_, count + 1);
    } else {
      face_colors_.add_grey();
    }
  }

  /// A vertex index, or kMissingVertex.
  std::uint32_t corner(std::size_t word) {
    const auto index = lines_.number<std::uint32_t>(word);
    if (index < vertices_) return index;
    const std::string message =
        "a face refers to vertex " + std::to_string(index) + ", but there are " + std::to_string(vertices_);
    if (bad_faces_ == BadFaces::kError) lines_.fail(message);
    if (polygons_.first_missing.empty()) polygons_.first_missing = message;
    return kMissingVertex;
  }

  void add_faces() {
    Mesh& mesh = out_.mesh;
    const std::vector<std::uint32_t> sources = append_polygons(polygons_, mesh, out_.warnings);
    if (mesh.triangles.empty()) {
      const std::string& missing = polygons_.first_missing;
      throw SceneError({file_, 0}, missing.empty() ? "has no faces" : "no face is complete: " + missing);
    }
    if (vertex_colors_.has_any()) mesh.attributes.push_back({"vertex_color", 3, vertex_colors_.take()});
    if (!face_colors_.has_any()) return;
    const std::vector<float> colors = face_colors_.take();
    Mesh::Attribute attribute{"face_color", 3, {}};
    for (const std::uint32_t polygon : sources) {
      const auto first = colors.begin() + 3 * static_cast<std::ptrdiff_t>(polygon);
      attribute.values.insert(attribute.values.end(), first, first + 3);
    }
    mesh.attributes.push_back(std::move(attribute));
  }

  const std::string& text_;
  const std::string file_;
  WordLines lines_;
  BadFaces bad_faces_;
  VertexParts parts_;
  std::size_t vertices_ = 0, faces_ = 0;
  PolygonList polygons_;
  Colors vertex_colors_, face_colors_;
  MeshFile out_;
};

}  // namespace

MeshFile read_off(const std::filesystem::path& file, BadFaces bad_faces) {
  const std::string text = read_mesh_text(file, "OFF file");
  return OffReader(text, file.string(), bad_faces).read();
}

}  // namespace sheaf

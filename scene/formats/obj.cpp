// Wavefront OBJ files, parsed by tinyobjloader: the only file that includes it.
//
// The library reads each piece of the text over a stream buffer that points into memory, and calls back per line. It
// does not report errors, line numbers and smoothing groups, its numbers are not rounded correctly, and it takes
// comments for corners. So lines that are not plain (scene/formats/obj_text.h) are parsed by parse_obj_line().
#include "scene/formats/obj.h"

#include "core/io/read_ahead.h"
#include "scene/formats/obj_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <istream>
#include <limits>
#include <mutex>
#include <streambuf>
#include <utility>

// The library calls these functions of the C library for every number. Its own namespace is searched first, so it gets
// versions for its sets of characters that compilers can inline: reading takes three quarters of the time.
namespace tinyobj {

/// `set` has at most four characters.
inline bool is_one_of(char c, const char* set) {
  for (int i = 0; i < 4 && set[i] != '\0'; ++i)
    if (c == set[i]) return true;
  return false;
}

inline std::size_t strspn(const char* text, const char* set) {
  const char* end = text;
  while (is_one_of(*end, set)) ++end;
  return static_cast<std::size_t>(end - text);
}

inline std::size_t strcspn(const char* text, const char* set) {
  const char* end = text;
  while (*end != '\0' && !is_one_of(*end, set)) ++end;
  return static_cast<std::size_t>(end - text);
}

inline int atoi(const char* text) {
  const bool is_negative = *text == '-';
  if (*text == '-' || *text == '+') ++text;
  unsigned value = 0;
  for (; *text >= '0' && *text <= '9'; ++text) value = 10 * value + static_cast<unsigned>(*text - '0');
  return static_cast<int>(is_negative ? 0 - value : value);
}

}  // namespace tinyobj

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

namespace sheaf {

namespace {

/// A stream buffer over a text in memory.
class TextBuffer : public std::streambuf {
 public:
  explicit TextBuffer(std::string_view text) {
    char* const begin = const_cast<char*>(text.data());  // never written to
    setg(begin, begin, begin + text.size());
  }
  /// The character that is read next.
  const char* position() const { return gptr(); }
};

/// Reads one piece of a file.
class PieceReader {
 public:
  /// `room`: an empty piece whose lists have room.
  PieceReader(const ObjText& text, ObjPiece room)
      : text_(text),
        piece_(text.text()),
        plain_(piece_),
        lines_(text),
        buffer_(piece_),
        done_(piece_.data()),
        content_(std::move(room)) {}

  ObjPiece read() {
    tinyobj::callback_t callbacks;
    callbacks.vertex_cb = [](void* reader, float x, float y, float z, float) {
      static_cast<PieceReader*>(reader)->take_numbers(ObjLine::Kind::kPosition, {x, y, z});
    };
    callbacks.normal_cb = [](void* reader, float x, float y, float z) {
      static_cast<PieceReader*>(reader)->take_numbers(ObjLine::Kind::kNormal, {x, y, z});
    };
    callbacks.texcoord_cb = [](void* reader, float x, float y, float z) {
      static_cast<PieceReader*>(reader)->take_numbers(ObjLine::Kind::kUv, {x, y, z});
    };
    callbacks.index_cb = [](void* reader, tinyobj::index_t* corners, int count) {
      static_cast<PieceReader*>(reader)->take_face(corners, static_cast<std::size_t>(count));
    };
    std::istream stream(&buffer_);
    try {
      tinyobj::LoadObjWithCallback(stream, callbacks, this);
      parse_lines(done_, piece_.data() + piece_.size());
      content_.line_count = lines_.line_at(piece_.data() + piece_.size());
    } catch (const SceneError&) { content_.error = std::current_exception(); }
    return content_;  // a copy, without room for more
  }

  /// The room of the lists, for another piece.
  ObjPiece take_room() {
    const auto clear = [](auto&... lists) { (lists.clear(), ...); };
    clear(content_.positions, content_.normals, content_.uvs, content_.corners, content_.faces, content_.relative_faces,
          content_.statements);
    content_.short_faces = 0;
    content_.highest = {-1, -1, -1};
    content_.error = nullptr;
    return std::move(content_);
  }

 private:
  /// Adds a line of numbers, with 0 for missing ones, unless the lines since the last call must be parsed again.
  void take_numbers(ObjLine::Kind kind, Vec3f numbers) {
    const auto [begin, end] = take_lines();
    constexpr float kFiveDigits = 1e5f;
    const bool may_lack_numbers = kind == ObjLine::Kind::kUv ? numbers.x == 0 : numbers.z == 0;
    const float largest = std::max({std::abs(numbers.x), std::abs(numbers.y), std::abs(numbers.z)});
    const bool is_plain = *begin == 'v' && largest < kFiveDigits &&
                          plain_.has_plain_numbers(offset(begin), offset(end)) &&
                          (!may_lack_numbers || count_numbers(begin, end) >= (kind == ObjLine::Kind::kUv ? 1 : 3));
    if (!is_plain) return parse_lines(begin, end);
    add_numbers(kind, numbers, false);
  }

  /// Likewise for a face.
  void take_face(const tinyobj::index_t* corners, std::size_t count) {
    const auto [begin, end] = take_lines();
    bool is_plain = *begin == 'f' && plain_.has_plain_indices(offset(begin), offset(end));
    for (std::size_t i = 0; i < count; ++i) is_plain = is_plain && corners[i].vertex_index != 0;
    if (!is_plain) return parse_lines(begin, end);
    add_face(begin, count, [&](std::size_t i) {
      return ObjCorner{corners[i].vertex_index, corners[i].texcoord_index, corners[i].normal_index};
    });
  }

  /// Returns the lines that the library has read since the last call, but for empty ones at the beginning. The last one
  /// is that of the callback.
  std::pair<const char*, const char*> take_lines() {
    const char* begin = std::exchange(done_, buffer_.position());
    while (is_line_end(*begin)) ++begin;
    return {begin, done_};
  }

  /// Parses whole lines without the library.
  void parse_lines(const char* begin, const char* end) {
    while (begin != end) {
      const char* const stop = std::find_if(begin, end, is_line_end);
      parse_obj_line(text_, {begin, stop}, line_);
      add(begin);
      begin = stop + 1;  // the LF of CR LF is an empty line
    }
  }

  void add(const char* line) {
    using Kind = ObjLine::Kind;
    switch (line_.kind) {
      case Kind::kPosition:
      case Kind::kNormal:
      case Kind::kUv:
        return add_numbers(line_.kind, line_.numbers, line_.is_non_finite);
      case Kind::kFace:
        return add_face(line, line_.corners.size(), [&](std::size_t i) { return line_.corners[i]; });
      case Kind::kMaterial:
      case Kind::kLibrary:
      case Kind::kSmoothing:
        content_.statements.push_back(
            {content_.faces.size(), line_.kind, std::string(line_.name), line_.group, lines_.line_at(line)});
        return;
      case Kind::kIrrelevant:
        return;
    }
  }

  void add_numbers(ObjLine::Kind kind, Vec3f numbers, bool is_non_finite) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    const bool is_usable = !is_non_finite && is_finite(numbers);
    if (kind == ObjLine::Kind::kPosition) {
      content_.positions.push_back(is_non_finite ? Vec3f{kNan, kNan, kNan} : numbers);
    } else if (kind == ObjLine::Kind::kNormal) {
      content_.normals.push_back(is_usable ? numbers : Vec3f{0, 0, 0});
    } else {
      content_.uvs.push_back(is_usable ? Vec2f{numbers.x, numbers.y} : Vec2f{0, 0});
    }
  }

  template <class CornerAt> void add_face(const char* line, std::size_t count, CornerAt corner_at) {
    if (count < 3) {
      ++content_.short_faces;
      return;
    }
    int lowest = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const ObjCorner corner = corner_at(i);
      lowest = std::min({lowest, corner.position, corner.uv, corner.normal});
      content_.corners.push_back({corner.position - 1, corner.uv - 1, corner.normal - 1});
      ObjCorner& highest = content_.highest;
      highest.position = std::max(highest.position, corner.position - 1);
      highest.uv = std::max(highest.uv, corner.uv - 1);
      highest.normal = std::max(highest.normal, corner.normal - 1);
    }
    if (lowest < 0)
      content_.relative_faces.push_back({content_.faces.size(), static_cast<int>(content_.positions.size()),
                                         static_cast<int>(content_.uvs.size()),
                                         static_cast<int>(content_.normals.size())});
    content_.faces.push_back(
        {static_cast<std::uint32_t>(content_.corners.size()), static_cast<std::uint32_t>(line - piece_.data())});
  }

  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

  /// Number of words behind the keyword of a plain line.
  static int count_numbers(const char* begin, const char* end) {
    const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
    int count = 0;
    for (const char* p = begin + 1; p < end; ++p) count += is_blank(p[-1]) && !is_blank(*p) && !is_line_end(*p) ? 1 : 0;
    return count;
  }

  std::size_t offset(const char* position) const { return static_cast<std::size_t>(position - piece_.data()); }

  const ObjText& text_;
  const std::string_view piece_;
  const PlainObjLines plain_;
  ObjLineCounter lines_;
  TextBuffer buffer_;
  const char* done_;  ///< end of the lines that are in content_
  ObjLine line_;
  ObjPiece content_;
};

/// Memory that one piece after the other uses: lists that grow fragment the memory.
struct PieceRoom {
  ObjPiece lists;
  std::string text;
};

/// The rooms that no piece is using.
class SpareRooms {
 public:
  PieceRoom take() {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return {};
    PieceRoom room = std::move(spare_.back());
    spare_.pop_back();
    return room;
  }
  void give(PieceRoom room) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(room));
  }

 private:
  std::mutex mutex_;
  std::vector<PieceRoom> spare_;
};

ObjPiece read_piece(const ObjSource& source, ObjSource::Range range, SpareRooms& spare) {
  if (range.size() > std::numeric_limits<std::uint32_t>::max())
    throw SceneError(SourceLocation{source.file()}, "the OBJ file has a line of more than 4 GiB");
  PieceRoom room = spare.take();
  ObjText text(source, range, std::move(room.text));
  PieceReader reader(text, std::move(room.lists));
  ObjPiece content = reader.read();
  content.begin = range.begin;
  spare.give({reader.take_room(), text.take_buffer()});
  return content;
}

/// Reads the pieces by all threads.
std::vector<ObjPiece> read_pieces(const ObjSource& source, std::size_t piece_bytes) {
  SpareRooms spare;
  std::vector<ReadAhead<ObjPiece>::Job> jobs;
  for (const ObjSource::Range range : source.pieces(piece_bytes))
    jobs.push_back({[&, range] { return read_piece(source, range, spare); }, 2 * static_cast<double>(range.size())});
  std::vector<ObjPiece> pieces(jobs.size());
  ReadAhead<ObjPiece> readers(std::move(jobs), pieces.size() > 1 ? read_ahead_bytes() : 0);
  for (std::size_t i = 0; i < pieces.size(); ++i) pieces[i] = readers.take(i);
  return pieces;
}

}  // namespace

ObjFile read_obj_with_materials(const std::filesystem::path& file, bool flip_tex_coords, BadFaces bad_faces,
                                std::size_t piece_bytes) {
  const ObjSource source(file);
  ObjContent content = join_obj_pieces(source, read_pieces(source, piece_bytes), bad_faces);
  if (flip_tex_coords) {
    for (Vec2f& uv : content.uvs.values) uv.y = 1 - uv.y;
  }
  const std::string first_bad = content.positions.first_bad;
  ObjFile obj = build_obj_mesh(std::move(content));
  if (obj.file.mesh.triangles.empty())
    throw SceneError(SourceLocation{file.string()}, "no face is complete: " + first_bad);
  return obj;
}

MeshFile read_obj(const std::filesystem::path& file, bool flip_tex_coords, BadFaces bad_faces) {
  return read_obj_with_materials(file, flip_tex_coords, bad_faces).file;
}

}  // namespace sheaf

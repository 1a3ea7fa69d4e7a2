// The text of an OBJ file, and the thin pass over it that finds what tinyobjloader does not read as Sheaf does.
#pragma once

#include "core/io/error.h"
#include "scene/formats/mesh_io.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// An OBJ file, of which threads read pieces. Lines end in LF, CR LF or CR.
class ObjSource {
 public:
  /// Positions [begin, end) in the file.
  struct Range {
    std::size_t begin, end;
    std::size_t size() const { return end - begin; }
  };

  /// Throws SceneError, also for empty files.
  explicit ObjSource(const std::filesystem::path& file);

  const std::string& file() const { return name_; }
  /// Cuts the file at line ends into pieces of about `bytes`, but not within continued lines, which end in a backslash.
  std::vector<Range> pieces(std::size_t bytes) const;
  /// Reads a piece; safe to call from any thread. Ends the last line if the file does not.
  void read(Range piece, std::string& text) const;
  /// Location of the line that begins at this position. Reads the file up to there.
  SourceLocation where(std::size_t position) const;

 private:
  std::size_t end_of_line(std::size_t position) const;

  std::string name_;
  MeshTextFile text_;
};

/// A piece of an OBJ file. Continued lines of vertices and faces are joined: blanks replace the backslash and the line
/// end.
class ObjText {
 public:
  /// `buffer`: memory for the text.
  ObjText(const ObjSource& source, ObjSource::Range piece, std::string buffer = {});

  std::string_view text() const { return text_; }
  /// Location of the line that begins at `line`, a pointer into the text. Slow.
  SourceLocation where(const char* line) const;
  /// Returns the memory, for another piece.
  std::string take_buffer() { return std::move(text_); }

 private:
  friend class ObjLineCounter;
  void join_continued_lines();

  const ObjSource& source_;
  const std::size_t begin_;  ///< position in the file
  std::string text_;
  std::vector<std::size_t> joined_;  ///< positions in the text of the line ends that became blanks
};

/// Numbers of lines of a piece, from 0, at ascending positions.
class ObjLineCounter {
 public:
  explicit ObjLineCounter(const ObjText& text) : text_(text) {}

  /// Number of the line that begins at `line`, which must not precede that of the previous call.
  int line_at(const char* line);

 private:
  const ObjText& text_;
  std::size_t position_ = 0, joined_ = 0;
  int line_ = 0;
};

/// Finds the lines that tinyobjloader reads exactly as parse_obj_line(): a keyword of the letters v, f, n and t at the
/// beginning of the line, and indices of at most 9 digits or numbers without exponent and with at most 7 decimals. The
/// library computes such numbers in double precision with a relative error below 9 x 2^-53. Below 10^5, no such decimal
/// is closer to the middle of two floats than 2^-25 x 10^-7 of its value, so the library's floats are correctly
/// rounded.
class PlainObjLines {
 public:
  /// Checks all bytes, independent of each other, so compilers use SIMD instructions. The text must consist of whole
  /// lines.
  explicit PlainObjLines(std::string_view text);

  /// Whether the lines in [begin, end) of the text are plain lines of numbers. There may be too few numbers, and they
  /// may exceed 10^5.
  bool has_plain_numbers(std::size_t begin, std::size_t end) const {
    return (found(begin, end) & (kOdd | kHasSlash)) == 0;
  }
  /// Whether the lines are plain faces. The index of a position may be 0.
  bool has_plain_indices(std::size_t begin, std::size_t end) const {
    return (found(begin, end) & (kOdd | kHasDot)) == 0;
  }

 private:
  static constexpr std::size_t kBlock = 64;
  static constexpr std::uint8_t kOdd = 1, kHasDot = 16, kHasSlash = 64;

  std::uint8_t found(std::size_t begin, std::size_t end) const {
    std::uint8_t all = 0;
    for (std::size_t block = begin / kBlock; block <= (end - 1) / kBlock; ++block) all |= found_[block];
    return all;
  }

  std::vector<std::uint8_t> found_;  ///< per block of 64 bytes
};

}  // namespace sheaf

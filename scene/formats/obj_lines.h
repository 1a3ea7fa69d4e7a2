// Parsing of the lines of an OBJ file.
#pragma once

#include "core/io/error.h"
#include "core/math/vec.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// An 'mtllib' line of an OBJ file.
struct ObjLibrary {
  std::string names;  ///< text after the keyword: a file, or several separated by blanks
  SourceLocation where;
};

/// Indices of a corner of a face as the file gives them: from 1, or negative from the end; 0: absent.
struct ObjIndices {
  int position, uv, normal;
};

/// Reads the relevant lines of an OBJ text one after the other: 'v', 'vn', 'vt', 'f' and 'usemtl', and 'mtllib' and 's'
/// on the way. Joins continued lines and skips comments. Throws SceneError with the line for malformed numbers and
/// indices.
class ObjLines {
 public:
  enum class Kind { kPosition, kNormal, kUv, kFace, kMaterial, kEnd };

  /// Modifies `text`, which must end in a line feed. Both arguments must outlive the object.
  ObjLines(std::string& text, const std::string& file);

  /// Moves to the next relevant line; kEnd after the last.
  Kind next();

  /// Numbers of a position, normal or texture coordinate, correctly rounded; missing ones are 0.
  Vec3f numbers() const { return numbers_; }
  /// Whether the line has a NaN or an infinity among its relevant numbers. numbers() is then not valid.
  bool is_non_finite() const { return is_non_finite_; }
  /// Corners of a face.
  const std::vector<ObjIndices>& corners() const { return corners_; }
  /// Name after 'usemtl', without quotation marks.
  std::string_view material() const { return material_; }

  /// Location of the line.
  SourceLocation where() const { return {file_, line_}; }
  int line() const { return line_; }
  /// Smoothing group of the faces that follow: 0 (flat) after 's off' and before the first 's'.
  std::uint32_t smoothing_group() const { return smoothing_group_; }
  /// Whether an 's' line was found so far.
  bool has_smoothing_groups() const { return has_smoothing_groups_; }
  /// The 'mtllib' lines found so far.
  const std::vector<ObjLibrary>& libraries() const { return libraries_; }

 private:
  /// Returns the end of the line that starts at text_; moves text_ past it. Lines end in LF, CR LF or CR.
  const char* end_of_line();
  /// Parses the line [p, end), which starts with its keyword. Returns whether it is relevant, and sets `kind`.
  bool parse(const char* p, const char* end, Kind& kind);
  /// Parses at least `min_count` numbers. Only the first `max_count` are relevant.
  void parse_numbers(const char* p, const char* end, int min_count, int max_count, const char* what);
  /// Parses corners v, v/vt, v//vn or v/vt/vn, with trailing slashes ("1//").
  void parse_face(const char* p, const char* end);
  /// Parses the argument of 's': a number, 'on' or 'off'.
  void parse_smoothing_group(const char* p, const char* end);

  char* text_;
  char* const end_;
  const std::string& file_;
  const bool has_carriage_returns_;
  int line_ = 0, next_line_ = 1;
  Vec3f numbers_{};
  bool is_non_finite_ = false;
  std::vector<ObjIndices> corners_;
  std::string_view material_;
  std::uint32_t smoothing_group_ = 0;
  bool has_smoothing_groups_ = false;
  std::vector<ObjLibrary> libraries_;
};

}  // namespace sheaf

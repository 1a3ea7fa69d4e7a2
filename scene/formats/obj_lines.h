// Validation of the lines of an OBJ file before tinyobjloader parses them.
#pragma once

#include "core/error.h"

#include <cstdint>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// An 'mtllib' line of an OBJ file.
struct ObjLibrary {
  std::string names;  ///< text after the keyword: a file, or several separated by blanks
  SourceLocation where;
};

/// Stream buffer that supplies only the relevant lines of an OBJ text: 'v', 'vn', 'vt', 'f' and 'usemtl'. It supplies
/// one line at a time, so that the line number is known while the parser works on it. Joins continued lines and removes
/// comments. Throws SceneError for malformed numbers and indices, which tinyobjloader would read as 0.
class ObjLines : public std::streambuf {
 public:
  /// Modifies `text`, which must end in a line feed. Both arguments must outlive the buffer.
  ObjLines(std::string& text, const std::string& file) : text_(text.data()), end_(text_ + text.size()), file_(file) {}

  /// Location of the line supplied last.
  SourceLocation where() const { return {file_, line_}; }
  /// Whether that line has a NaN or an infinity among its relevant numbers.
  bool line_is_non_finite() const { return non_finite_; }
  /// Smoothing group of the faces that follow: 0 (flat) after 's off' and before the first 's'.
  std::uint32_t smoothing_group() const { return smoothing_group_; }
  /// Whether an 's' line was found so far.
  bool has_smoothing_groups() const { return has_smoothing_groups_; }
  /// The 'mtllib' lines found so far.
  const std::vector<ObjLibrary>& libraries() const { return libraries_; }

 protected:
  int_type underflow() override;

 private:
  /// Returns the end of the line that starts at text_; moves text_ past it. Lines end in LF, CR LF or CR.
  char* end_of_line();
  /// Validates a line; returns whether it is relevant.
  bool check(char* p, char* end);
  /// Throws unless at least `min_count` numbers follow. Only the first `max_count` are relevant.
  void check_numbers(char* p, char* end, int min_count, int max_count, const char* what);
  /// Validates corners v, v/vt, v//vn or v/vt/vn. Blanks out trailing slashes ("1//").
  void check_face(char* p, char* end);
  /// Reads the argument of 's': a number, 'on' or 'off'.
  void read_smoothing_group(char* p, char* end);

  char* text_;
  char* const end_;
  const std::string& file_;
  int line_ = 0, next_line_ = 1;
  bool non_finite_ = false;
  std::uint32_t smoothing_group_ = 0;
  bool has_smoothing_groups_ = false;
  std::vector<ObjLibrary> libraries_;
};

}  // namespace sheaf

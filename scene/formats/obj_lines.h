// The lines of an OBJ file, checked before tinyobjloader reads them.
#pragma once

#include "core/error.h"

#include <cstdint>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// A line 'mtllib' of an OBJ file.
struct ObjLibrary {
  std::string names;  ///< what stands behind the keyword: a file, or several with blanks between them
  SourceLocation where;
};

/// Hands out the lines of an OBJ text that matter to a mesh ('v', 'vn', 'vt', 'f' and 'usemtl'), one at a time: while
/// the reader works on a line, the buffer knows its number. Joins continued lines, removes comments, and throws
/// SceneError where a number or an index is malformed: tinyobjloader would read it as 0.
class ObjLines : public std::streambuf {
 public:
  /// `text` is changed on the way and must end in a line feed. Both arguments must outlive the buffer.
  ObjLines(std::string& text, const std::string& file) : text_(text.data()), end_(text_ + text.size()), file_(file) {}

  /// The line handed out last.
  SourceLocation where() const { return {file_, line_}; }
  /// Whether that line has a NaN or an infinity among the numbers that count.
  bool line_is_non_finite() const { return non_finite_; }
  /// The smoothing group of the faces that follow: 0 is flat, as 's off' says, and as it is before the first 's'.
  std::uint32_t smoothing_group() const { return smoothing_group_; }
  /// Whether there was a line 's' so far.
  bool has_smoothing_groups() const { return has_smoothing_groups_; }
  /// The lines 'mtllib' so far.
  const std::vector<ObjLibrary>& libraries() const { return libraries_; }

 protected:
  int_type underflow() override;

 private:
  /// Where the line that begins at text_ ends; moves text_ behind it. Lines end in LF, CR LF or CR.
  char* end_of_line();
  /// Whether the line matters.
  bool check(char* p, char* end);
  /// Throws unless `least` numbers or more follow; of these the first `most` count.
  void check_numbers(char* p, char* end, int least, int most, const char* what);
  /// Corners are v, v/vt, v//vn or v/vt/vn. Slashes with nothing behind them ("1//") are blanked out.
  void check_face(char* p, char* end);
  /// Behind 's': a number, 'on' or 'off'.
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

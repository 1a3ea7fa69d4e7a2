// Text files with numbers on each line.
#pragma once

#include "core/io/error.h"

#include <span>
#include <string>
#include <string_view>

namespace sheaf {

/// Iterates over the lines of a text, which end in LF, CR LF or CR.
class NumberLines {
 public:
  /// Both arguments must outlive the object.
  NumberLines(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  /// Advances to the next line; returns false at the end.
  bool next();
  /// The current line without surrounding blanks.
  std::string_view line() const { return line_; }
  /// Reads the numbers of the line into `numbers`. Throws SceneError if their count differs, or if one is malformed or
  /// not finite. `what` names them in the message.
  void read(std::span<float> numbers, const char* what) const;
  [[noreturn]] void fail(const std::string& message) const {
    throw SceneError(SourceLocation{file_, number_}, message);
  }

 private:
  std::string_view rest_, line_;
  const std::string& file_;
  int number_ = 0;
};

}  // namespace sheaf

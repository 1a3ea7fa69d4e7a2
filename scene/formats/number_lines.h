// Text files of numbers, some on each line.
#pragma once

#include "core/error.h"

#include <span>
#include <string>
#include <string_view>

namespace sheaf {

/// Hands out the lines of a text, which end in LF, CR LF or CR.
class NumberLines {
 public:
  /// Both arguments must outlive the object.
  NumberLines(std::string_view text, const std::string& file) : rest_(text), file_(file) {}

  /// Goes on to the next line; false at the end.
  bool next();
  /// The line, without blanks around it.
  std::string_view line() const { return line_; }
  /// Reads as many numbers as the line must hold. Throws SceneError if there are more or fewer, if one is malformed or
  /// not finite. `what`: what they are, for the message.
  void read(std::span<float> numbers, const char* what) const;
  [[noreturn]] void fail(const std::string& message) const { throw SceneError({file_, number_}, message); }

 private:
  std::string_view rest_, line_;
  const std::string& file_;
  int number_ = 0;
};

}  // namespace sheaf

// Remarks of readers and of the scene compiler for the user.
#pragma once

#include <string>
#include <vector>

namespace sheaf {

struct Remarks {
  std::vector<std::string> notes;     ///< about substituted or ignored elements
  std::vector<std::string> warnings;  ///< about errors that are corrected, with file and line
  /// Lenient reading: messages about what was dropped or replaced, with file and line
  std::vector<std::string> substitutions;
};

}  // namespace sheaf

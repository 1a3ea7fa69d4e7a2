// Lists of known names for error messages.
#pragma once

#include <string>
#include <vector>

namespace sheaf {

/// Formats a list of names as " (known: a, b, c)".
inline std::string known_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? " (known: " : ", ") + name;
  return text + ")";
}

}  // namespace sheaf

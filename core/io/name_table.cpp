// Lists of names in messages.
#include "core/io/name_table.h"

namespace sheaf {

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string known_names(const std::vector<std::string>& names) {
  return " (known: " + (names.empty() ? "none" : joined(names)) + ")";
}

std::string one_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

}  // namespace sheaf

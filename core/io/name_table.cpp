// Lists of names in messages.
#include "core/io/name_table.h"

#include <fmt/format.h>

namespace sheaf {

std::string joined(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

std::string known_names(const std::vector<std::string>& names) {
  return fmt::format(" (known: {})", names.empty() ? "none" : joined(names));
}

std::string unknown_option(std::string_view what, std::string_view name, const std::vector<std::string>& known) {
  return fmt::format("unknown {} '{}'{}{}", what, name, did_you_mean(name, known), known_names(known));
}

std::string one_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

}  // namespace sheaf

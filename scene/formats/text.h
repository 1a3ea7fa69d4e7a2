// Text utilities for file readers and messages.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace sheaf {

/// Removes the characters of `blanks` from both ends.
inline std::string_view trimmed(std::string_view text, std::string_view blanks = " \t") {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Removes surrounding double quotation marks.
inline std::string_view unquoted(std::string_view text) {
  if (text.size() < 2 || !text.starts_with('"') || !text.ends_with('"')) return text;
  return text.substr(1, text.size() - 2);
}

/// Encloses the text in quotation marks, truncated to 40 characters.
inline std::string quoted(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  return fmt::format("'{}{}", text.substr(0, kLongest), text.size() > kLongest ? "...'" : "'");
}

}  // namespace sheaf

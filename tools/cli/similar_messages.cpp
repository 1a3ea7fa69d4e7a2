#include "tools/cli/similar_messages.h"

#include <fmt/format.h>

#include <cctype>
#include <unordered_map>

namespace sheaf {

namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// The message without "FILE:LINE: " at its beginning.
std::string without_location(const std::string& message) {
  for (std::size_t colon = message.find(": "); colon != std::string::npos; colon = message.find(": ", colon + 1)) {
    std::size_t line = colon;
    while (line > 0 && is_digit(message[line - 1])) --line;
    if (line < colon && line > 0 && message[line - 1] == ':') return message.substr(colon + 2);
  }
  return message;
}

/// The message without its location, and with '#' for each number.
std::string kind_of(const std::string& message) {
  std::string kind;
  for (const char c : without_location(message)) {
    if (!is_digit(c))
      kind += c;
    else if (kind.empty() || kind.back() != '#')
      kind += '#';
  }
  return kind;
}

}  // namespace

std::vector<std::string> without_similar(const std::vector<std::string>& messages, std::size_t limit) {
  struct Kind {
    std::size_t count = 0, last = 0;  ///< last: index of the message
  };
  // Count the messages of each kind
  std::unordered_map<std::string, Kind> kinds;
  std::vector<Kind*> kind_of_message;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    Kind& kind = kinds[kind_of(messages[i])];
    ++kind.count;
    kind.last = i;
    kind_of_message.push_back(&kind);
  }
  // Keep the first ones, and never replace a single line by another
  std::vector<std::string> kept;
  std::unordered_map<const Kind*, std::size_t> written;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const Kind& kind = *kind_of_message[i];
    const bool shortened = kind.count > limit + 1;
    if (!shortened || written[&kind]++ < limit) kept.push_back(messages[i]);
    if (shortened && i == kind.last)
      kept.push_back(
          fmt::format("{} more like \"{}\"; -v prints them", kind.count - limit, without_location(messages[i])));
  }
  return kept;
}

}  // namespace sheaf

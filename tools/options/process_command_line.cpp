#include "tools/options/process_command_line.h"

#include <algorithm>
#include <cctype>
#include <fstream>

namespace sheaf {

std::string shell_quoted(std::string_view word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string command_line() {
  std::ifstream words("/proc/self/cmdline", std::ios::binary);
  std::string line;
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("_-+=.,:/@%").find(static_cast<char>(c)) != std::string_view::npos;
  };
  for (std::string word; std::getline(words, word, '\0');) {
    const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), is_plain);
    line += (line.empty() ? "" : " ") + (plain ? word : shell_quoted(word));
  }
  return line;
}

}  // namespace sheaf

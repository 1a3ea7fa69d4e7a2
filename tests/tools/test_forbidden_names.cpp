// Names that no C++ file may contain, with what takes their place.
#include <doctest/doctest.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

namespace {

namespace fs = std::filesystem;

struct ForbiddenName {
  std::string name;
  std::string_view replacement;
};

/// Composed, so that this file does not contain them.
const ForbiddenName kForbiddenNames[] = {
    {std::string("Appr") + "ox", "near() or within() of tests/support/near.h, whose tolerances are relative"}};

/// Number of the first line that contains a name as a whole word; 0: none.
int line_with(std::string_view text, std::string_view name) {
  const auto is_in_word = [&](std::size_t i) {
    return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) != 0 || text[i] == '_');
  };
  for (std::size_t at = text.find(name); at != text.npos; at = text.find(name, at + 1)) {
    if ((at > 0 && is_in_word(at - 1)) || is_in_word(at + name.size())) continue;
    int line = 1;
    for (const char c : text.substr(0, at)) line += c == '\n' ? 1 : 0;
    return line;
  }
  return 0;
}

}  // namespace

TEST_CASE("forbidden names: no file contains one") {
  const fs::path root = SHEAF_SOURCE_DIR;
  int files = 0;
  for (const char* const folder : {"core", "scene", "kernels", "tools", "tests", "bench"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      for (const auto& [name, replacement] : kForbiddenNames)
        if (const int line = line_with(text.str(), name); line > 0)
          FAIL_CHECK(fs::relative(entry.path(), root).generic_string()
                     << ":" << line << ": forbidden name '" << name << "' (use " << replacement << ")");
    }
  CHECK(files > 500);
}

TEST_CASE("forbidden names: only whole words count") {
  CHECK(line_with("a\nb == lib::Word(1)\nWord", "Word") == 2);
  CHECK(line_with("Word", "Word") == 1);
  CHECK(line_with("useWord Words WORD _Word\nWord2", "Word") == 0);
  CHECK(line_with("", "Word") == 0);
}

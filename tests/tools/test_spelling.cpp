// American spelling in the code and the documentation.
#include <doctest/doctest.h>

#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf::test_spelling {

namespace {

namespace fs = std::filesystem;

/// British stems, composed so that this file does not contain them.
const std::array<std::string, 9> kBritish = {
    std::string("colo") + "ur", std::string("cent") + "re",    std::string("neighbo") + "ur",
    std::string("gre") + "y",   std::string("behavio") + "ur", std::string("fib") + "re",
    std::string("met") + "re",  std::string("normal") + "ise", std::string("optim") + "ise"};

/// Whether a line has a British word, other than in quoted names, in names of files, and joined to others by "_", "/"
/// or "-".
bool has_british(std::string_view line) {
  std::string lower;
  for (const char c : line) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto at = [&](std::size_t i) { return i < lower.size() ? lower[i] : ' '; };
  const auto is_letter = [&](std::size_t i) { return std::isalpha(static_cast<unsigned char>(at(i))) != 0; };
  for (const std::string& stem : kBritish)
    for (std::size_t i = lower.find(stem); i != lower.npos; i = lower.find(stem, i + 1)) {
      std::size_t begin = i, end = i + stem.size();
      while (begin > 0 && is_letter(begin - 1)) --begin;
      while (is_letter(end)) ++end;
      const std::string_view joints = "_/-\"'";
      const char before = begin > 0 ? lower[begin - 1] : ' ';
      if (joints.find(before) != joints.npos || joints.find(at(end)) != joints.npos) continue;
      if (at(end) == '.' && is_letter(end + 1)) continue;  // a file
      return true;
    }
  return false;
}

const std::set<std::string> kExtensions = {".h", ".cpp", ".md", ".py", ".sh", ".xml", ".pbrt", ".cmake"};

std::vector<std::string> british_lines() {
  std::vector<std::string> found;
  const fs::path root = SHEAF_SOURCE_DIR;
  for (const char* const folder : {"core", "scene", "kernels", "tools", "docs", "scenes", "bench", "cmake"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const fs::path extension = entry.path().extension();
      if (kExtensions.count(extension.string()) == 0) continue;
      std::ifstream file(entry.path());
      int number = 0;
      bool in_block = false;  // of code in Markdown, which quotes other files
      for (std::string line; std::getline(file, line);) {
        ++number;
        if (extension == ".md" && line.starts_with("```")) in_block = !in_block;
        if (!in_block && has_british(line))
          found.push_back(fs::relative(entry.path(), root).generic_string() + ":" + std::to_string(number) + ": " +
                          line);
      }
    }
  return found;
}

}  // namespace

TEST_CASE("spelling: code and documentation are American") {
  for (const std::string& line : british_lines()) FAIL_CHECK(line);
}

TEST_CASE("spelling: British words are found, but not in names of files") {
  const std::string word = std::string("colo") + "ur";
  CHECK(has_british("the " + word + "s of"));
  CHECK(has_british("k" + word));
  CHECK_FALSE(has_british("color, center and gray"));
  CHECK_FALSE(has_british("a_" + word + ".exr"));
  CHECK_FALSE(has_british("\"" + word + "\""));
  CHECK_FALSE(has_british(word + ".exr"));
}

}  // namespace sheaf::test_spelling

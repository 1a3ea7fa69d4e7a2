// The terms of docs/glossary.md are terms of the code.
#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// The words of a text in lower case, each between single spaces. The parts of identifiers are words of their own:
/// `SlotTable` and `slot_table` both become " slot table ".
std::string words_of(std::string_view text) {
  std::string words = " ";
  bool after_lower = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool is_letter = std::isalnum(c) != 0 || c >= 0x80, is_upper = std::isupper(c) != 0;
    const bool before_lower = i + 1 < text.size() && std::islower(static_cast<unsigned char>(text[i + 1])) != 0;
    // Separate words, and the parts of names in camel case
    if ((!is_letter || (is_upper && (after_lower || before_lower))) && words.back() != ' ') words += ' ';
    if (is_letter) words += static_cast<char>(std::tolower(c));
    after_lower = std::islower(c) != 0;
  }
  return words.back() == ' ' ? words : words + ' ';
}

/// The terms of the tables of a glossary. A cell may list several, separated by commas. Abbreviations in parentheses
/// are omitted.
std::vector<std::string> terms_of(const std::string& glossary) {
  std::vector<std::string> terms;
  std::istringstream lines(glossary);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| ") || line.starts_with("| term ") || line.starts_with("| ---")) continue;
    std::string cell = line.substr(2, line.find(" | ") - 2);
    cell.resize(std::min(cell.find(" ("), cell.size()));
    std::istringstream parts(cell);
    for (std::string term; std::getline(parts, term, ',');) terms.push_back(term);
  }
  return terms;
}

/// Whether a term occurs in the words of the code, in the singular or in the plural.
bool occurs(const std::string& term, const std::string& code) {
  std::string words = words_of(term);
  if (code.find(words) != code.npos) return true;
  words.pop_back();
  return code.find(words + "s ") != code.npos || code.find(words + "es ") != code.npos;
}

/// The words of all sources of the product.
const std::string& product_words() {
  static const std::string words = [] {
    std::string all;
    for (const char* const folder : {"core", "scene", "kernels", "tools"})
      for (const auto& entry : fs::recursive_directory_iterator(fs::path(SHEAF_SOURCE_DIR) / folder))
        if (const fs::path extension = entry.path().extension(); extension == ".h" || extension == ".cpp")
          all += words_of(read(entry.path()));
    return all;
  }();
  return words;
}

}  // namespace

TEST_CASE("glossary: every term occurs in the code") {
  const std::vector<std::string> terms = terms_of(read(fs::path(SHEAF_SOURCE_DIR) / "docs/glossary.md"));
  CHECK(terms.size() > 120);
  for (const std::string& term : terms) {
    CAPTURE(term);
    CHECK(occurs(term, product_words()));
  }
}

TEST_CASE("glossary: terms that do not occur in the code are found") {
  const std::string table =
      "| term | meaning |\n| --- | --- |\n| wave, flux capacitor | x |\n| slot table (ST) | y |\n";
  const std::vector<std::string> terms = terms_of(table);
  REQUIRE(terms.size() == 3);
  CHECK(occurs(terms[0], product_words()));
  CHECK_FALSE(occurs(terms[1], product_words()));
  CHECK(occurs(terms[2], product_words()));
  CHECK_FALSE(occurs("slot capacitor", product_words()));
}

TEST_CASE("glossary: the words of identifiers are compared") {
  CHECK(words_of("SlotTable slot_table, kNone: HDRImage") == " slot table slot table k none hdr image ");
  CHECK(occurs("photon map", words_of("class PhotonMaps;")));
  CHECK_FALSE(occurs("photon map", words_of("photon_mapping")));
}

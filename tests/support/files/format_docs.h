// The reference of the scene format, docs/scene-format/*.md: sections of plugins, their tables of parameters, and
// their snippets.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <utility>
#include <vector>

namespace sheaf::test {

/// A row of a table of parameters.
struct DocumentedParameter {
  std::vector<std::string> names;  ///< the alternatives "`a` or `b`" of one parameter
  std::string type, default_value, meaning;
  std::string location;  ///< file and line
};

/// The text below a heading.
struct DocumentedSection {
  std::string page;                ///< name of the file without its extension
  std::vector<std::string> names;  ///< of plugins, in the heading; empty for general sections
  std::string text;                ///< prose and tables
  std::string location;
  std::vector<DocumentedParameter> parameters;
  std::vector<std::string> snippets;
};

/// Matches of a pattern with one group.
inline std::vector<std::string> all_matches(const std::string& text, const char* pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), regex), end; at != end; ++at) found.push_back((*at)[1].str());
  return found;
}

/// The text in backticks.
inline std::vector<std::string> code_in(const std::string& text) { return all_matches(text, "`([^`]+)`"); }

inline std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(' '), end = text.find_last_not_of(' ');
  return begin == std::string::npos ? std::string() : text.substr(begin, end - begin + 1);
}

/// Parts of a list "a, b, c"; commas inside of brackets and quotation marks do not count.
inline std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    depth += text[i] == '(' || text[i] == '[' ? 1 : text[i] == ')' || text[i] == ']' ? -1 : 0;
    quoted = quoted != (text[i] == '"');
    const bool separates = text[i] == ',' && depth == 0 && !quoted && i + 1 < text.size() && text[i + 1] == ' ';
    if (separates)
      parts.emplace_back();
    else
      parts.back() += text[i];
  }
  for (std::string& part : parts) part = trimmed(part);
  return parts;
}

/// Cells of a row "| a | b |"; "\|" does not separate.
inline std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (row[i] == '|' && (i == 0 || row[i - 1] != '\\'))
      cells.emplace_back();
    else if (!cells.empty())
      cells.back() += row[i];
  }
  if (!cells.empty()) cells.pop_back();
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

/// Adds the parameters of a row: one for each name, or for each group of alternative names.
inline void add_parameters(const std::vector<std::string>& cells, const std::string& location,
                           std::vector<DocumentedParameter>& out) {
  const bool are_alternatives = cells[0].find(" or ") != std::string::npos;
  const std::vector<std::string> names = are_alternatives ? std::vector{cells[0]} : parts_of(cells[0]);
  const std::string& defaults = cells[2];
  const std::vector<std::string> values = parts_of(defaults);
  for (std::size_t i = 0; i < names.size(); ++i) {
    DocumentedParameter parameter;
    parameter.names = code_in(names[i]);
    if (parameter.names.empty()) parameter.names = {names[i]};
    parameter.type = cells[1];
    parameter.default_value = values.size() == names.size() ? values[i] : defaults;
    parameter.meaning = cells.back();
    parameter.location = location;
    out.push_back(std::move(parameter));
  }
}

/// Reads the sections of one page. The first is the text below the title.
inline std::vector<DocumentedSection> sections_of(const std::filesystem::path& file) {
  std::vector<DocumentedSection> sections;
  std::ifstream stream(file);
  bool in_snippet = false, in_table = false;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    const std::string location = "docs/scene-format/" + file.filename().string() + ":" + std::to_string(++number);
    if (in_snippet) {
      in_snippet = !line.starts_with("```");
      if (in_snippet) sections.back().snippets.back() += line + "\n";
      continue;
    }
    if (line.starts_with("#")) sections.push_back({file.stem().string(), code_in(line), {}, location, {}, {}});
    if (sections.empty()) continue;
    DocumentedSection& section = sections.back();
    in_snippet = line.starts_with("```");
    if (in_snippet) {
      section.snippets.emplace_back();
      continue;
    }
    section.text += line + "\n";
    // Tables of parameters begin with "| name | type | default |"
    const bool is_row = line.starts_with("|");
    const bool is_header = line.starts_with("| name | type | default |");
    if (in_table && is_row && !line.starts_with("| ---")) add_parameters(cells_of(line), location, section.parameters);
    in_table = is_header || (in_table && is_row);
  }
  return sections;
}

/// Reads all pages about XML scenes.
inline std::vector<DocumentedSection> format_sections() {
  std::vector<DocumentedSection> all;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(SHEAF_SOURCE_DIR "/docs/scene-format"))
    if (entry.path().extension() == ".md" && entry.path().stem() != "pbrt") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files)
    for (DocumentedSection& section : sections_of(file)) all.push_back(std::move(section));
  return all;
}

/// Names of the plugins whose parameters a section has as well: links [`name`](...) in sentences such as "It has all
/// parameters of" and "As".
inline std::vector<std::string> inherited_by(const DocumentedSection& section) {
  static const char* const kPhrases[] = {"parameters of", "As [",      "as [",
                                         "Read as",       "same as [", "same parameters",
                                         "files only",    "as for [",  "and the roughness of"};
  std::vector<std::string> names;
  std::string text = section.text;
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(". ", begin), text.size());
    const std::string sentence = text.substr(begin, end - begin);
    const bool inherits = std::any_of(std::begin(kPhrases), std::end(kPhrases),
                                      [&](const char* phrase) { return sentence.find(phrase) != std::string::npos; });
    if (inherits)
      for (const std::string& name : all_matches(sentence, "\\[`([^`]+)`\\]\\(")) names.push_back(name);
    begin = end + 2;
  }
  return names;
}

}  // namespace sheaf::test

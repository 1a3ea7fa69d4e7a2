// Formats help like other programs: names in a column on the left, descriptions beside or below them.
#include "tools/options/help.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace sheaf {

namespace {

/// Columns of the names of options, of the names of commands, and the minimum of the descriptions.
constexpr std::size_t kNameColumns = 26, kCommandColumns = 14, kMinTextColumns = 20;

constexpr const char* kPlaceholders[] = {"", "N", "X", "TIME", "TEXT", "FILE", "FOLDER"};
constexpr const char* kKindNames[] = {"none", "integer", "number", "time", "text", "file", "folder"};

std::string joined(const std::vector<std::string>& words, const char* separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

/// Breaks the text at spaces into lines of at most `columns` characters, and at its line breaks. Longer words get lines
/// of their own.
std::vector<std::string> wrapped(const std::string& text, std::size_t columns) {
  std::vector<std::string> lines;
  std::istringstream paragraphs(text);
  for (std::string paragraph; std::getline(paragraphs, paragraph);) {
    std::istringstream words(paragraph);
    std::string line;
    for (std::string word; words >> word;) {
      if (!line.empty() && line.size() + 1 + word.size() > columns) {
        lines.push_back(line);
        line.clear();
      }
      line += (line.empty() ? "" : " ") + word;
    }
    lines.push_back(line);
  }
  return lines;
}

/// An entry of a list: the name, and the text beside it, or below it if the name is too long.
std::string entry(const std::string& name, const std::string& text, std::size_t name_columns, std::size_t columns) {
  const std::size_t text_columns = std::max(kMinTextColumns, columns - std::min(columns, name_columns));
  std::string out = "  " + name;
  bool is_beside = out.size() + 2 <= name_columns;
  for (const std::string& line : wrapped(text, text_columns)) {
    out += is_beside ? std::string(name_columns - out.size(), ' ') : "\n" + std::string(name_columns, ' ');
    out += line;
    is_beside = false;
  }
  return out + "\n";
}

std::string option_entry(const OptionHelp& option, std::size_t columns) {
  // Options without a short name align with the long names of the others
  const bool has_short = option.is_argument || option.names.front().size() == 2;
  const std::string name = (has_short ? "" : "    ") + joined(option.names, ", ");
  const std::string value = option.is_argument ? "" : placeholder_of(option);
  return entry(name + (value.empty() ? "" : " " + value), option.text, kNameColumns, columns);
}

std::string usage(const CommandHelp& command, const std::string& program) {
  std::string text = (program.empty() ? "" : program + " ") + command.name;
  if (!command.commands.empty()) return text + " COMMAND [OPTIONS]";
  text += " [OPTIONS]";
  for (const OptionHelp& option : command.options) {
    if (!option.is_argument) continue;
    const std::string name = option.names.front() + (option.repeats ? "..." : "");
    text += option.required ? " " + name : fmt::format(" [{}]", name);
  }
  return text;
}

nlohmann::ordered_json option_json(const OptionHelp& option) {
  nlohmann::ordered_json json{{"names", option.names},
                              {"text", option.text},
                              {"group", option.group},
                              {"kind", kKindNames[static_cast<int>(option.kind)]},
                              {"placeholder", placeholder_of(option)},
                              {"words", option.words},
                              {"only_words", option.only_words},
                              {"positive", option.is_positive},
                              {"count", option.count},
                              {"repeats", option.repeats},
                              {"required", option.required},
                              {"argument", option.is_argument}};
  if (std::isfinite(option.min)) json["min"] = option.min;
  if (std::isfinite(option.max)) json["max"] = option.max;
  return json;
}

nlohmann::ordered_json command_json(const CommandHelp& command, const std::string& program) {
  nlohmann::ordered_json json{{"name", command.name},
                              {"text", command.text},
                              {"usage", usage(command, program)},
                              {"footer", command.footer},
                              {"groups", command.groups},
                              {"options", nlohmann::ordered_json::array()},
                              {"commands", nlohmann::ordered_json::array()}};
  for (const OptionHelp& option : command.options) json["options"].push_back(option_json(option));
  for (const CommandHelp& each : command.commands) json["commands"].push_back(command_json(each, command.name));
  return json;
}

}  // namespace

const CommandHelp* CommandHelp::find(const std::string& command) const {
  const auto found =
      std::find_if(commands.begin(), commands.end(), [&](const CommandHelp& each) { return each.name == command; });
  return found == commands.end() ? nullptr : &*found;
}

std::string placeholder_of(const OptionHelp& option) {
  if (option.kind == ValueKind::kFlag) return "";
  if (!option.placeholder.empty()) return option.placeholder;
  if (option.only_words) return joined(option.words, "|");
  std::string text = kPlaceholders[static_cast<int>(option.kind)];
  for (int i = 1; i < option.count; ++i) text += std::string(",") + kPlaceholders[static_cast<int>(option.kind)];
  return text;
}

std::string first_sentence(const std::string& text) {
  std::size_t end = text.find(". ");
  while (end != std::string::npos && text.substr(0, end).ends_with("e.g")) end = text.find(". ", end + 1);
  std::string sentence = text.substr(0, std::min(end, text.find('\n')));
  while (sentence.ends_with('.') || sentence.ends_with(':')) sentence.pop_back();
  return sentence;
}

std::string help_text(const CommandHelp& command, const std::string& program, int columns) {
  const auto width = static_cast<std::size_t>(columns);
  std::string out;
  // Describe the command and its arguments
  for (const std::string& line : wrapped(command.text, width)) out += line + "\n";
  out += fmt::format("\nUsage: {}\n", usage(command, program));
  bool has_arguments = false;
  for (const OptionHelp& option : command.options) {
    if (!option.is_argument) continue;
    out += (has_arguments ? "" : "\nArguments:\n") + option_entry(option, width);
    has_arguments = true;
  }
  // List the subcommands, and the options by group
  if (!command.commands.empty()) out += "\nCommands:\n";
  for (const CommandHelp& each : command.commands)
    out += entry(each.name, first_sentence(each.text), kCommandColumns, width);
  std::vector<std::string> groups = command.groups;
  groups.insert(groups.begin(), "");  // options without a group
  for (const std::string& group : groups) {
    std::string entries;
    for (const OptionHelp& option : command.options)
      if (!option.is_argument && option.group == group) entries += option_entry(option, width);
    if (!entries.empty()) out += fmt::format("\n{}:\n{}", group.empty() ? "Options" : group, entries);
  }
  // Add the footer
  if (!command.footer.empty()) out += "\n";
  for (const std::string& line : wrapped(command.footer, width)) out += line + "\n";
  return out;
}

std::string to_json(const CommandHelp& program, const std::string& version) {
  nlohmann::ordered_json json = command_json(program, "");
  json["version"] = version;
  return json.dump(2) + "\n";
}

}  // namespace sheaf

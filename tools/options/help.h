// The commands and options of a program as declared. Help, manual pages and shell completion derive from it.
#pragma once

#include "tools/options/option_value.h"

#include <functional>
#include <limits>
#include <list>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// The kind of an option's value; kFlag: it takes none.
enum class ValueKind { kFlag, kInteger, kNumber, kTime, kText, kFile, kFolder };

/// An option or a positional argument.
struct OptionHelp {
  std::vector<std::string> names;  ///< "-o", "--output"; or the name of the argument
  std::string text;                ///< lines after the first are a list
  std::string group;               ///< title in the help; empty: none
  ValueKind kind = ValueKind::kFlag;
  std::string placeholder;              ///< of the value in the help, "WxH"; empty: by kind
  std::vector<std::string> words = {};  ///< values to complete
  bool only_words = false;              ///< other values are errors
  std::string implied = {};             ///< the value if none of `words` follows the option; empty: one must follow
  bool is_list = false;                 ///< accepts several words, separated by commas
  double min = -std::numeric_limits<double>::infinity(), max = std::numeric_limits<double>::infinity();
  bool is_positive = false;  ///< a number above 0
  int count = 1;             ///< numbers in the value, separated by commas
  bool repeats = false, required = false, is_argument = false;
  bool is_fraction = false;   ///< accepts percentages
  bool only_for_run = false;  ///< see Option::only_for_run()
  /// Sets the variable of the option; returns the value as GivenOption::values. Throws Error (exit code 2).
  std::function<std::string(const OptionValue& value)> set = {};
};

/// A program or a subcommand.
struct CommandHelp {
  std::string name, text;
  std::string footer = {};  ///< of the help
  std::list<OptionHelp> options = {};
  std::list<OptionHelp> hidden_options = {};  ///< accepted, but not in the help
  std::list<CommandHelp> commands = {};
  std::vector<std::string> groups = {};  ///< titles of the groups of options, in the order of the help
  std::string group = {};                ///< of the options that are declared next
  bool has_common_options = false;       ///< --help and --version are among the options

  /// The command of that name; null if no command has it.
  const CommandHelp* find(const std::string& command) const;
};

/// The value of an option in the help: "FILE", "rgb|spectral"; empty if it takes none.
std::string placeholder_of(const OptionHelp& option);

/// The first sentence of a text, without its full stop.
std::string first_sentence(const std::string& text);

/// The text of --help, wrapped at `columns` characters. `program`: the name of the program that `command` belongs to,
/// or empty.
std::string help_text(const CommandHelp& command, const std::string& program, int columns);

/// The commands and options as JSON text, for the scripts that make manual pages and documentation.
std::string to_json(const CommandHelp& program, const std::string& version);

}  // namespace sheaf

// Command-line parser: options and arguments bound to variables, and subcommands. Wraps CLI11, which is slow to compile
// and which no other file includes.
#pragma once

#include "tools/options/help.h"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sheaf {

/// An option of a command and the constraints on its values. Violations are usage errors.
class Option {
 public:
  Option(CLI::Option& option, OptionHelp& help) : option_(&option), help_(&help) {}

  /// The option is mandatory.
  Option& required();
  /// Requires a value in [low, high]. T: int, unsigned, float or double.
  template <class T> Option& in_range(T low, T high);
  /// Requires a positive number.
  Option& positive();
  /// Accepts a fraction or a percentage: 2% means 0.02.
  Option& fraction();
  /// Accepts a time in seconds or with units: 90s, 5m, 1h30m.
  Option& seconds();
  /// Requires one of these words.
  Option& one_of(const std::vector<std::string>& words);
  /// Requires one of these words and converts it to its number.
  Option& one_of_named(const std::map<std::string, int>& words);
  /// After one_of(): the option may be given without a value, and then has the value `word`.
  Option& implies(const std::string& word);
  /// The value is the name of a file, or of a folder.
  Option& file();
  Option& folder();
  /// Sets the placeholder of the value in the help, such as WxH.
  Option& placeholder(const std::string& text);
  /// Sets words that shells complete. Other values remain valid. `is_list`: several words, separated by commas.
  Option& suggest(const std::vector<std::string>& words, bool is_list = false);
  /// Takes `count` values in one word, separated by `delimiter`.
  Option& list(char delimiter, int count);
  /// The option may be given several times.
  Option& repeated();
  /// The values do not affect the image's bits, only the run and the outputs. See GivenOption.
  Option& only_for_run();

 private:
  CLI::Option* option_;
  OptionHelp* help_;
};

/// An option on the command line.
struct GivenOption {
  std::string name;    ///< the longest name, without dashes
  std::string values;  ///< separated by commas
  bool affects_image;  ///< not Option::only_for_run()
};

/// A program or one of its subcommands. `names` of options are like "-o,--output", or "scene" for a positional
/// argument. Variables and the command must live until the command line is parsed.
class Command {
 public:
  Command(CLI::App& command, CommandHelp& help) : command_(&command), help_(&help) {}

  /// Begins a group of options, which has a title in the help.
  void begin_group(const std::string& title);

  /// Adds an option that sets `value`. T: std::string, int, unsigned, double, an optional of int, unsigned, float or
  /// double, or a vector of int or float (see Option::list). Numbers are decimal. Integers may also be written 16.0 or
  /// 1e3.
  template <class T> Option add_option(const std::string& names, T& value, const std::string& help);
  /// Adds an option that may be repeated and takes one value each time.
  Option add_option(const std::string& names, std::vector<std::string>& values, const std::string& help);
  /// Adds a variable number of positional arguments.
  Option add_arguments(const std::string& name, std::vector<std::string>& values, const std::string& help);
  /// Adds an option without a value, which sets `value` to true.
  Option add_flag(const std::string& names, bool& value, const std::string& help);
  /// Adds an option without a value, which may be repeated and sets `value` to how often it is given.
  Option add_counter(const std::string& names, int& value, const std::string& help);
  /// Replaces the help of an option or argument, by its longest name.
  void set_help(const std::string& name, const std::string& text);
  /// Leaves options out of the help and of what derives from it. They are still accepted.
  void hide(const std::vector<std::string>& names);
  /// Adds a subcommand.
  Command add_command(const std::string& name, const std::string& help);
  /// The names of the subcommands so far.
  std::vector<std::string> command_names() const;
  /// The options on the command line, in the order of add_option(). Call this after parsing.
  std::vector<GivenOption> given() const;
  /// Sets the variables of options from a program instead of a command line, by their names without dashes. Returns
  /// these options, in the order of add_option(). Throws Error (exit code 2).
  std::vector<GivenOption> set(const std::map<std::string, OptionValue>& values) const;
  /// Sets the action to run after parsing. Its exceptions propagate out of Program::parse().
  void on_call(std::function<void()> action);

 protected:
  Option describe(CLI::Option& option, const std::string& names, ValueKind kind, const std::string& help);

  CLI::App* command_;
  CommandHelp* help_;
};

/// The command line of a program.
class Program : public Command {
 public:
  Program(const std::string& name, const std::string& help);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Sets the text at the end of --help.
  void set_footer(const std::string& text);
  /// Sets the output of --version, and the lines that follow it with -v.
  void set_version(const std::string& text, std::function<std::string()> details);
  /// Requires exactly one subcommand.
  void require_command();
  /// Sets the variables and runs the subcommand. Returns an exit code if the program should end: 0 after --help or
  /// --version, 2 after a usage error. Usage errors are printed in one line that begins with the program's name.
  std::optional<int> parse(int argc, char** argv);
  /// The same for the words after the program's name, from another source than a command line. Throws Error (exit code
  /// 2) with the message of a usage error, also for --help and --version.
  void parse(const std::vector<std::string>& words);
  /// Adds --help and --version to the help of all commands, and returns it. Call this after all options are declared.
  const CommandHelp& help();
  const std::string& version() const { return version_; }

 private:
  std::unique_ptr<CommandHelp> owned_help_;
  std::string version_;
  std::function<std::string()> version_details_;
  std::unique_ptr<CLI::App> app_;
};

}  // namespace sheaf

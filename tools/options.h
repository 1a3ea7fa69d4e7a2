// The command line of a program: options and arguments bound to variables, and subcommands. Wraps CLI11, which takes
// long to compile and which no other file includes.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace sheaf {

/// An option of a command, and what its values must be; others are usage errors.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  /// It must be given.
  Option& required();
  /// Its value is from low to high, both included. T: int, unsigned, float or double.
  template <class T> Option& in_range(T low, T high);
  /// Its value is a number above zero.
  Option& positive();
  /// Its value is a share, which may be given in per cent: 2% for 0.02.
  Option& share();
  /// Its value is a time in seconds, which may be given with units: 90s, 5m, 1h30m.
  Option& seconds();
  /// Its value is one of these words.
  Option& one_of(const std::vector<std::string>& words);
  /// Its value is one of these words, each of which stands for a number.
  Option& one_of_named(const std::map<std::string, int>& words);
  /// Its values are given as one word, `count` of them with `delimiter` between.
  Option& list(char delimiter, int count);

 private:
  CLI::Option* option_;
};

/// A program or one of its subcommands. `names` of options are like "-o,--output", or "scene" for an argument that is
/// known by its place. Variables and the command must live until the command line is parsed.
class Command {
 public:
  explicit Command(CLI::App& command) : command_(&command) {}

  /// An option that sets `value`. T: std::string, int, unsigned, double, an optional of int, unsigned, float or
  /// double, or a vector of int or float (see Option::list). Numbers are decimal; whole ones may be written 16.0 or
  /// 1e3.
  template <class T> Option add_option(const std::string& names, T& value, const std::string& help);
  /// An option that may be repeated and takes one value each time.
  Option add_option(const std::string& names, std::vector<std::string>& values, const std::string& help);
  /// Arguments that are known by their place, as many as there are.
  Option add_arguments(const std::string& name, std::vector<std::string>& values, const std::string& help);
  /// An option without a value, which sets `value` to true.
  void add_flag(const std::string& names, bool& value, const std::string& help);
  /// A subcommand.
  Command add_command(const std::string& name, const std::string& help);
  /// The options that were given, their longest name without dashes and their values with commas between, in the order
  /// in which they were added. To be called once the options are set.
  std::vector<std::pair<std::string, std::string>> given() const;
  /// What to do once the options are set. What it throws comes out of Program::parse().
  void on_call(std::function<void()> action);

 protected:
  CLI::App* command_;
};

/// The command line of a whole program.
class Program : public Command {
 public:
  Program(const std::string& name, const std::string& help);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// What --help ends with.
  void set_footer(const std::string& text);
  /// What --version prints.
  void set_version(const std::string& text);
  /// One subcommand must be given.
  void require_command();
  /// Sets the variables and calls the subcommand given. Returns an exit code if the program is to end there: after
  /// --help and --version (0), and once a usage error is printed (2), in one line that begins with the program's name.
  std::optional<int> parse(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace sheaf

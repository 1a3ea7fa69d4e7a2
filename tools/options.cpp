#include "tools/options.h"

#include "core/error.h"

#include <CLI/CLI.hpp>

#include <cmath>
#include <iostream>
#include <type_traits>

namespace sheaf {

namespace {

/// Numbers that comparisons say nothing of are in no range.
CLI::Validator finite() {
  return CLI::Validator(
      [](const std::string& text) {
        double value = 0;
        const bool is_number = CLI::detail::lexical_cast(text, value);
        return is_number && std::isfinite(value) ? std::string() : "'" + text + "' is not a finite number";
      },
      "");
}

/// What is said of arguments that nobody knows: the first of them, and what may have been meant.
std::string unknown_argument(const CLI::App& program, const std::vector<std::string>& rest) {
  const CLI::App* command = &program;
  for (const CLI::App* each : program.get_subcommands()) command = each;
  std::vector<std::string> options, commands;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  for (const CLI::App* each : command->get_subcommands({})) commands.push_back(each->get_name());
  for (const std::string& argument : rest)
    if (argument.starts_with("-"))
      return "unknown option '" + argument + "'" + did_you_mean(argument.substr(0, argument.find('=')), options);
  const std::string& word = rest.front();
  if (commands.empty()) return "unexpected argument '" + word + "'";
  std::string known;
  for (const std::string& name : commands) known += (known.empty() ? "" : ", ") + name;
  return "unknown command '" + word + "'" + did_you_mean(word, commands) + " (" + known + ")";
}

}  // namespace

Option& Option::required() {
  option_->required();
  return *this;
}

template <class T> Option& Option::in_range(T low, T high) {
  if constexpr (std::is_floating_point_v<T>) option_->check(finite());
  option_->check(CLI::Range(low, high));
  return *this;
}

template Option& Option::in_range(int, int);
template Option& Option::in_range(unsigned, unsigned);
template Option& Option::in_range(double, double);
template Option& Option::in_range(float, float);

Option& Option::positive() {
  const auto above_zero = [](const std::string& text) {
    double value = 0;
    const bool is_positive = CLI::detail::lexical_cast(text, value) && value > 0;
    return is_positive ? std::string() : "'" + text + "' is not a number above 0";
  };
  option_->check(finite())->check(CLI::Validator(above_zero, "POSITIVE"));
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option& Option::one_of_named(const std::map<std::string, int>& words) {
  option_->transform(CLI::CheckedTransformer(words))->type_name("ENUM");
  return *this;
}

Option& Option::list(char delimiter, int count) {
  option_->delimiter(delimiter)->expected(count);
  return *this;
}

template <class T> Option Command::add_option(const std::string& names, T& value, const std::string& help) {
  return Option(*command_->add_option(names, value, help));
}

template Option Command::add_option(const std::string&, std::string&, const std::string&);
template Option Command::add_option(const std::string&, int&, const std::string&);
template Option Command::add_option(const std::string&, unsigned&, const std::string&);
template Option Command::add_option(const std::string&, double&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<unsigned>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<float>&, const std::string&);
template Option Command::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<int>&, const std::string&);
template Option Command::add_option(const std::string&, std::vector<float>&, const std::string&);

Option Command::add_option(const std::string& names, std::vector<std::string>& values, const std::string& help) {
  return Option(*command_->add_option(names, values, help)->allow_extra_args(false));
}

Option Command::add_arguments(const std::string& name, std::vector<std::string>& values, const std::string& help) {
  return Option(*command_->add_option(name, values, help));
}

void Command::add_flag(const std::string& names, bool& value, const std::string& help) {
  command_->add_flag(names, value, help);
}

Command Command::add_command(const std::string& name, const std::string& help) {
  return Command(*command_->add_subcommand(name, help));
}

std::vector<std::pair<std::string, std::string>> Command::given() const {
  std::vector<std::pair<std::string, std::string>> options;
  for (const CLI::Option* option : command_->get_options()) {
    if (option->count() == 0) continue;
    const std::string name = option->get_lnames().empty() ? option->get_name() : option->get_lnames().front();
    std::string values;
    for (const std::string& value : option->results()) values += (values.empty() ? "" : ",") + value;
    options.emplace_back(name, values);
  }
  return options;
}

void Command::on_call(std::function<void()> action) { command_->callback(std::move(action)); }

Program::Program(const std::string& name, const std::string& help)
    : Command(*new CLI::App(help, name)), app_(command_) {}

Program::~Program() = default;

void Program::set_footer(const std::string& text) { app_->footer(text); }

void Program::set_version(const std::string& text) { app_->set_version_flag("--version", text); }

void Program::require_command() { app_->require_subcommand(1); }

std::optional<int> Program::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::CallForHelp& help) { return app_->exit(help); } catch (const CLI::ParseError& problem) {
    // A word that is no command is told as a command that is missing.
    const std::vector<std::string> rest = app_->remaining(true);
    const bool about_them = dynamic_cast<const CLI::ExtrasError*>(&problem) != nullptr ||
                            (dynamic_cast<const CLI::RequiredError*>(&problem) != nullptr && !rest.empty());
    if (about_them && !rest.empty()) {
      std::cerr << unknown_argument(*app_, rest) << "\nRun with --help for more information.\n";
      return static_cast<int>(ExitCode::kUsage);
    }
    return app_->exit(problem) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
}

}  // namespace sheaf

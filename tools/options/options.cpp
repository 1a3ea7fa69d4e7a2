#include "tools/options/options.h"

#include "core/io/error.h"
#include "tools/console/terminal.h"
#include "tools/options/number_text.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <iostream>
#include <limits>
#include <sstream>
#include <type_traits>

namespace sheaf {

namespace {

CLI::Validator transform(std::string (*function)(std::string&)) { return CLI::Validator(function, ""); }

/// The subcommand on the command line, or the program.
const CLI::App& called_command(const CLI::App& program) {
  const CLI::App* command = &program;
  for (const CLI::App* each : program.get_subcommands()) command = each;
  return *command;
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// The program and its subcommand, e.g. "sheaf render".
std::string full_name(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return (parent != nullptr ? full_name(*parent) + " " : "") + command.get_name();
}

/// Message for an option that precedes its subcommand. Empty if no subcommand has the option.
std::string misplaced_option(const CLI::App& program, const std::string& option) {
  const CLI::App& called = called_command(program);
  std::vector<const CLI::App*> commands = program.get_subcommands({});
  if (&called != &program) commands.insert(commands.begin(), &called);
  for (const CLI::App* command : commands) {
    const std::vector<std::string> names = option_names(*command);
    if (std::find(names.begin(), names.end(), option) == names.end()) continue;
    return fmt::format("option '{}' must follow its command: {} {}", option, full_name(*command), option);
  }
  return {};
}

/// Message for unknown arguments, with the first one and the most similar name.
std::string unknown_argument(const CLI::App& program) {
  const CLI::App& command = called_command(program);
  const auto name_of = [](const std::string& argument) { return argument.substr(0, argument.find('=')); };
  for (const std::string& argument : program.remaining(false)) {
    if (!argument.starts_with("-")) continue;
    const std::string misplaced = misplaced_option(program, name_of(argument));
    return misplaced.empty()
               ? fmt::format("unknown option '{}'{}", argument, did_you_mean(name_of(argument), option_names(program)))
               : misplaced;
  }
  const std::vector<std::string> rest = program.remaining(true);
  for (const std::string& argument : rest)
    if (argument.starts_with("-"))
      return fmt::format("unknown option '{}'{}", argument, did_you_mean(name_of(argument), option_names(command)));
  std::vector<std::string> commands;
  for (const CLI::App* each : command.get_subcommands({})) commands.push_back(each->get_name());
  const std::string& word = rest.front();
  if (commands.empty()) return fmt::format("unexpected argument '{}'", word);
  std::string known;
  for (const std::string& name : commands) known += (known.empty() ? "" : ", ") + name;
  return fmt::format("unknown command '{}'{} ({})", word, did_you_mean(word, commands), known);
}

/// Message for an invalid command line.
std::string usage_message(const CLI::App& program, const CLI::ParseError& problem) {
  // CLI11 reports an unknown subcommand as a missing one.
  const bool about_rest = dynamic_cast<const CLI::ExtrasError*>(&problem) != nullptr ||
                          dynamic_cast<const CLI::RequiredError*>(&problem) != nullptr;
  if (about_rest && !program.remaining(true).empty()) return unknown_argument(program);
  if (dynamic_cast<const CLI::RequiredError*>(&problem) != nullptr && &called_command(program) == &program) {
    std::string commands;
    for (const CLI::App* each : program.get_subcommands({}))
      commands += (commands.empty() ? "expected a command: " : ", ") + each->get_name();
    if (!commands.empty()) return commands;
  }
  std::string message = problem.what();
  std::replace(message.begin(), message.end(), '\n', ' ');
  return message;
}

/// The same without control characters.
std::string printable_usage_message(const CLI::App& program, const CLI::ParseError& problem) {
  std::string message = usage_message(program, problem);
  for (char& c : message)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  return message;
}

/// Rejects numbers that the option does not accept.
CLI::Validator number_check(const OptionHelp& help) {
  return CLI::Validator(
      [&help](const std::string& text) {
        const std::optional<double> value = number_of(text);
        return value ? problem_with(help, *value, text) : std::string();
      },
      "");
}

/// The numbers of an option's value: T, an optional T or several T.
template <class T> struct NumberTraits : std::is_arithmetic<T> { using Number = T; };
template <class T> struct NumberTraits<std::optional<T>> : NumberTraits<T> {};
template <class T> struct NumberTraits<std::vector<T>> : NumberTraits<T> {};

std::string joined(const std::vector<std::string>& values) {
  std::string text;
  for (const std::string& value : values) text += (text.empty() ? "" : ",") + value;
  return text;
}

/// Sets the variable of an option with numbers; see OptionHelp::set.
template <class T> std::string set_numbers(const OptionHelp& option, const OptionValue& value, T& variable) {
  using Number = typename NumberTraits<T>::Number;
  std::vector<Number> numbers;
  std::vector<std::string> texts;
  for (const double number : numbers_from(option, value)) {
    constexpr auto kLow = static_cast<double>(std::numeric_limits<Number>::lowest());
    constexpr auto kHigh = static_cast<double>(std::numeric_limits<Number>::max());
    if (number < kLow || number > kHigh) refuse_value(option, fmt::format("'{}' is too large", shortest(number)));
    numbers.push_back(static_cast<Number>(number));
    texts.push_back(shortest(number));
  }
  if constexpr (std::is_same_v<T, std::vector<Number>>)
    variable = numbers;
  else
    variable = numbers.front();
  return joined(texts);
}

}  // namespace

Option& Option::required() {
  option_->required();
  help_->required = true;
  return *this;
}

template <class T> Option& Option::in_range(T low, T high) {
  help_->min = static_cast<double>(low);
  help_->max = static_cast<double>(high);
  return *this;
}

template Option& Option::in_range(int, int);
template Option& Option::in_range(unsigned, unsigned);
template Option& Option::in_range(double, double);
template Option& Option::in_range(float, float);

Option& Option::positive() {
  help_->is_positive = true;
  return *this;
}

Option& Option::fraction() {
  option_->transform(transform(to_fraction));
  help_->is_fraction = true;
  return *this;
}

Option& Option::seconds() {
  option_->transform(transform(to_seconds));
  help_->kind = ValueKind::kTime;
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  help_->words = words;
  help_->only_words = true;
  return *this;
}

Option& Option::one_of_named(const std::map<std::string, int>& words) {
  option_->transform(CLI::CheckedTransformer(words));
  for (const auto& [word, number] : words) help_->words.push_back(word);
  help_->only_words = true;
  return *this;
}

Option& Option::implies(const std::string& word) {
  help_->implied = word;
  return *this;
}

Option& Option::file() {
  help_->kind = ValueKind::kFile;
  return *this;
}

Option& Option::folder() {
  help_->kind = ValueKind::kFolder;
  return *this;
}

Option& Option::placeholder(const std::string& text) {
  help_->placeholder = text;
  return *this;
}

Option& Option::suggest(const std::vector<std::string>& words, bool is_list) {
  help_->words = words;
  help_->is_list = is_list;
  return *this;
}

Option& Option::repeated() {
  help_->repeats = true;
  return *this;
}

Option& Option::list(char delimiter, int count) {
  option_->delimiter(delimiter)->expected(count);
  help_->count = count;
  return *this;
}

/// Sheaf has no configuration files, so CLI11's flag for these is free.
Option& Option::only_for_run() {
  option_->configurable(false);
  help_->only_for_run = true;
  return *this;
}

void Command::begin_group(const std::string& title) {
  std::vector<std::string>& groups = help_->groups;
  if (std::find(groups.begin(), groups.end(), title) == groups.end()) groups.push_back(title);
  help_->group = title;
}

Option Command::describe(CLI::Option& option, const std::string& names, ValueKind kind, const std::string& help) {
  OptionHelp& made = help_->options.emplace_back();
  std::istringstream words(names);
  for (std::string name; std::getline(words, name, ',');) made.names.push_back(name);
  made.text = help;
  made.kind = kind;
  made.is_argument = !names.starts_with('-');
  made.group = made.is_argument ? "" : help_->group;
  return Option(option, made);
}

template <class T> Option Command::add_option(const std::string& names, T& value, const std::string& help) {
  CLI::Option& option = *command_->add_option(names, value, help);
  if constexpr (NumberTraits<T>::value) {
    constexpr bool kIsWhole = std::is_integral_v<typename NumberTraits<T>::Number>;
    option.transform(transform(kIsWhole ? to_whole_number : to_number));
    const Option made = describe(option, names, kIsWhole ? ValueKind::kInteger : ValueKind::kNumber, help);
    OptionHelp& described = help_->options.back();
    option.check(number_check(described));
    described.set = [&described, &value](const OptionValue& given) { return set_numbers(described, given, value); };
    return made;
  } else {
    const Option made = describe(option, names, ValueKind::kText, help);
    OptionHelp& described = help_->options.back();
    described.set = [&described, &value](const OptionValue& given) { return value = text_from(described, given); };
    return made;
  }
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
  CLI::Option& option = *command_->add_option(names, values, help)->allow_extra_args(false);
  Option made = describe(option, names, ValueKind::kText, help).repeated();
  OptionHelp& described = help_->options.back();
  described.set = [&described, &values](const OptionValue& given) {
    values = texts_from(described, given);
    return joined(values);
  };
  return made;
}

Option Command::add_arguments(const std::string& name, std::vector<std::string>& values, const std::string& help) {
  return describe(*command_->add_option(name, values, help), name, ValueKind::kText, help).repeated();
}

Option Command::add_flag(const std::string& names, bool& value, const std::string& help) {
  const Option made = describe(*command_->add_flag(names, value, help), names, ValueKind::kFlag, help);
  OptionHelp& described = help_->options.back();
  described.set = [&described, &value](const OptionValue& given) -> std::string {
    const bool* const flag = std::get_if<bool>(&given);
    if (flag == nullptr) refuse_value(described, "expected true or false");
    value = *flag;
    return value ? "true" : "false";
  };
  return made;
}

Option Command::add_counter(const std::string& names, int& value, const std::string& help) {
  return describe(*command_->add_flag(names, value, help), names, ValueKind::kFlag, help).repeated();
}

void Command::set_help(const std::string& name, const std::string& text) {
  for (OptionHelp& option : help_->options)
    if (option.names.back() == name) option.text = text;
}

void Command::hide(const std::vector<std::string>& names) {
  std::list<OptionHelp>& options = help_->options;
  for (auto option = options.begin(); option != options.end();) {
    const auto each = option++;
    if (std::find(names.begin(), names.end(), each->names.back()) != names.end())
      help_->hidden_options.splice(help_->hidden_options.end(), options, each);  // checks of values refer to it
  }
}

Command Command::add_command(const std::string& name, const std::string& help) {
  return Command(*command_->add_subcommand(name, help), help_->commands.emplace_back(CommandHelp{name, help}));
}

std::vector<std::string> Command::command_names() const {
  std::vector<std::string> names;
  for (const CommandHelp& command : help_->commands) names.push_back(command.name);
  return names;
}

std::vector<GivenOption> Command::given() const {
  std::vector<GivenOption> options;
  for (const CLI::Option* option : command_->get_options()) {
    if (option->count() == 0) continue;
    const std::string name = option->get_lnames().empty() ? option->get_name() : option->get_lnames().front();
    options.push_back({name, joined(option->results()), option->get_configurable()});
  }
  return options;
}

std::vector<GivenOption> Command::set(const std::map<std::string, OptionValue>& values) const {
  std::vector<GivenOption> options;
  std::vector<std::string> names;
  for (const OptionHelp& option : help_->options) {
    const std::string& name = option.names.back();
    names.push_back(name.substr(std::min(name.find_first_not_of('-'), name.size())));
    const auto value = values.find(names.back());
    if (value != values.end() && option.set)
      options.push_back({names.back(), option.set(value->second), !option.only_for_run});
  }
  for (const auto& value : values) {
    const auto is_set = [&](const GivenOption& option) { return option.name == value.first; };
    if (std::none_of(options.begin(), options.end(), is_set))
      throw Error(ExitCode::kUsage,
                  fmt::format("unknown option '{}'{}", value.first, did_you_mean(value.first, names)));
  }
  return options;
}

void Command::on_call(std::function<void()> action) { command_->callback(std::move(action)); }

Program::Program(const std::string& name, const std::string& help)
    : Command(*new CLI::App(help, name), *new CommandHelp{name, help}), owned_help_(help_), app_(command_) {}

Program::~Program() = default;

void Program::set_footer(const std::string& text) { help_->footer = text; }

void Program::set_version(const std::string& text, std::function<std::string()> details) {
  version_ = text;
  version_details_ = std::move(details);
}

void Program::require_command() { app_->require_subcommand(1); }

namespace {

/// Adds --help, and --version if there is one, in a group of their own if other options are grouped.
void add_common_help(CommandHelp& command, bool has_version) {
  const std::string group = command.groups.empty() ? "" : "Help";
  if (!group.empty()) command.groups.push_back(group);
  const auto add = [&](std::vector<std::string> names, const std::string& text) {
    OptionHelp& option = command.options.emplace_back();
    option.names = std::move(names);
    option.text = text;
    option.group = group;
  };
  add({"-h", "--help"}, "Print this help and exit");
  if (has_version) add({"--version"}, "Print the version and exit");
}

/// The implied value of the option `name`, if `next` is not one of its values; otherwise empty.
std::string implied_value(const CommandHelp& program, const std::string& name, const std::string& next) {
  for (const CommandHelp& command : program.commands)
    for (const OptionHelp& option : command.options) {
      const auto contains = [](const std::vector<std::string>& list, const std::string& word) {
        return std::find(list.begin(), list.end(), word) != list.end();
      };
      if (!option.implied.empty() && contains(option.names, name) && !contains(option.words, next))
        return option.implied;
    }
  return "";
}

/// The command line, where options without a value have the one that they imply.
std::vector<std::string> with_implied_values(const CommandHelp& program, int argc, char** argv) {
  std::vector<std::string> words(argv, argv + argc);
  for (std::size_t i = 1; i < words.size() && words[i] != "--"; ++i) {
    const std::string value = implied_value(program, words[i], i + 1 < words.size() ? words[i + 1] : "");
    if (!value.empty()) words[i] += "=" + value;
  }
  return words;
}

}  // namespace

const CommandHelp& Program::help() {
  if (help_->has_common_options) return *help_;
  help_->has_common_options = true;
  add_common_help(*help_, !version_.empty());
  for (CommandHelp& command : help_->commands) add_common_help(command, !version_.empty());
  if (version_details_) {
    OptionHelp& option = help_->options.emplace_back();
    option.names = {"-v", "--verbose"};
    option.text = "With --version: also print the libraries and the image formats";
  }
  return *help_;
}

void Program::parse(const std::vector<std::string>& words) {
  std::vector<std::string> line{app_->get_name()};
  line.insert(line.end(), words.begin(), words.end());
  std::vector<char*> pointers;
  for (std::string& word : line) pointers.push_back(word.data());
  line = with_implied_values(*help_, static_cast<int>(pointers.size()), pointers.data());
  pointers.clear();
  for (std::string& word : line) pointers.push_back(word.data());
  try {
    app_->parse(static_cast<int>(pointers.size()), pointers.data());
  } catch (const CLI::ParseError& problem) { throw Error(ExitCode::kUsage, printable_usage_message(*app_, problem)); }
}

std::optional<int> Program::parse(int argc, char** argv) {
  if (!version_.empty()) {
    CLI::Option* const version = app_->set_version_flag("--version", version_);
    if (version_details_) app_->add_flag("-v,--verbose")->needs(version);
    for (CLI::App* command : app_->get_subcommands({})) command->set_version_flag("--version", version_);
  }
  try {
    std::vector<std::string> words = with_implied_values(*help_, argc, argv);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    app_->parse(static_cast<int>(pointers.size()), pointers.data());
    return std::nullopt;
  } catch (const CLI::CallForHelp&) {
    const CLI::App& command = called_command(*app_);
    const CommandHelp* const found = help().find(command.get_name());
    std::cout << (found != nullptr ? help_text(*found, help().name, text_columns())
                                   : help_text(help(), "", text_columns()));
    return 0;
  } catch (const CLI::CallForVersion&) {
    std::cout << version_ << '\n';
    const auto is_verbose = [](std::string_view word) { return word == "-v" || word == "--verbose"; };
    if (version_details_ && std::any_of(argv + 1, argv + argc, is_verbose)) std::cout << version_details_();
    return 0;
  } catch (const CLI::ParseError& problem) {
    std::cerr << app_->get_name() << ": " << printable_usage_message(*app_, problem) << " (see '"
              << full_name(called_command(*app_)) << " --help')\n";
    return static_cast<int>(ExitCode::kUsage);
  }
}

}  // namespace sheaf

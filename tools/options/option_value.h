// Values of options from a program instead of a command line.
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace sheaf {

struct OptionHelp;

/// A flag, a number, a text, or several of these. A number may also be given as on the command line: "1%", "90s".
using OptionValue = std::variant<bool, double, std::string, std::vector<double>, std::vector<std::string>>;

/// Why a number is not a value of the option; empty if it is one. `text`: the number as given.
std::string problem_with(const OptionHelp& option, double number, const std::string& text);

/// The value as the option takes it: OptionHelp::count numbers, one text or several texts. Throws Error (exit code 2)
/// for other kinds of values and for those that the option does not accept.
std::vector<double> numbers_from(const OptionHelp& option, const OptionValue& value);
std::string text_from(const OptionHelp& option, const OptionValue& value);
std::vector<std::string> texts_from(const OptionHelp& option, const OptionValue& value);

/// Throws Error (exit code 2) with the name of the option.
[[noreturn]] void refuse_value(const OptionHelp& option, const std::string& problem);

}  // namespace sheaf

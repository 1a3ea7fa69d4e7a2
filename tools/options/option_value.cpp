#include "tools/options/option_value.h"

#include "core/io/error.h"
#include "tools/options/help.h"
#include "tools/options/number_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace sheaf {

namespace {

/// A number that is given as on the command line.
double number_in(const OptionHelp& option, std::string text) {
  const std::string problem = option.is_fraction                   ? to_fraction(text)
                              : option.kind == ValueKind::kTime    ? to_seconds(text)
                              : option.kind == ValueKind::kInteger ? to_whole_number(text)
                                                                   : to_number(text);
  if (!problem.empty()) refuse_value(option, problem);
  return *number_of(text);
}

std::vector<double> numbers_in(const OptionHelp& option, const std::string& text) {
  if (option.count == 1) return {number_in(option, text)};
  std::vector<double> numbers;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) numbers.push_back(number_in(option, word));
  return numbers;
}

}  // namespace

void refuse_value(const OptionHelp& option, const std::string& problem) {
  throw Error(ExitCode::kUsage, fmt::format("{}: {}", option.names.back(), problem));
}

std::string problem_with(const OptionHelp& option, double number, const std::string& text) {
  const bool is_limited = option.is_positive || std::isfinite(option.min) || std::isfinite(option.max);
  if (is_limited && !std::isfinite(number)) return fmt::format("'{}' is not a finite number", text);
  if (option.kind == ValueKind::kInteger && number != std::floor(number))
    return fmt::format("'{}' is not an integer", text);
  if (number < option.min || number > option.max)
    return fmt::format("Value {} not in range {} to {}", text, shortest(option.min), shortest(option.max));
  if (option.is_positive && number <= 0) return fmt::format("'{}' is not a positive number", text);
  return {};
}

std::vector<double> numbers_from(const OptionHelp& option, const OptionValue& value) {
  std::vector<double> numbers;
  if (const auto* const number = std::get_if<double>(&value))
    numbers = {*number};
  else if (const auto* const several = std::get_if<std::vector<double>>(&value))
    numbers = *several;
  else if (const auto* const text = std::get_if<std::string>(&value))
    numbers = numbers_in(option, *text);
  if (numbers.size() != static_cast<std::size_t>(option.count))
    refuse_value(option, option.count == 1 ? "expected a number" : fmt::format("expected {} numbers", option.count));
  for (const double number : numbers)
    if (const std::string problem = problem_with(option, number, shortest(number)); !problem.empty())
      refuse_value(option, problem);
  return numbers;
}

std::string text_from(const OptionHelp& option, const OptionValue& value) {
  const bool* const flag = std::get_if<bool>(&value);
  const bool is_implied = flag != nullptr && *flag && !option.implied.empty();
  const auto* const text = is_implied ? &option.implied : std::get_if<std::string>(&value);
  if (text == nullptr) refuse_value(option, "expected a text");
  if (option.only_words && std::find(option.words.begin(), option.words.end(), *text) == option.words.end())
    refuse_value(option, fmt::format("{} not in {{{}}}", *text, fmt::join(option.words, ",")));
  return *text;
}

std::vector<std::string> texts_from(const OptionHelp& option, const OptionValue& value) {
  if (const auto* const texts = std::get_if<std::vector<std::string>>(&value)) return *texts;
  refuse_value(option, "expected several texts");
}

}  // namespace sheaf

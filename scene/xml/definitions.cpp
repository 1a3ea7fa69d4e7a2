#include "scene/xml/definitions.h"

#include "scene/xml/expression.h"

#include <algorithm>

namespace sheaf {

namespace {

constexpr std::size_t kLongestName = 128;
constexpr std::size_t kMaxSubstituted = std::size_t{1} << 28;  ///< total size of all substitutions, bytes

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/// The value of an entry. Of `frame`, if it is a number of digits and a digit from 1 to 9 follows in `rest`, that many
/// digits; `i` then skips the digit.
std::string with_digits(const std::pair<const std::string, std::string>& entry, std::string_view rest, std::size_t& i) {
  const std::string& value = entry.second;
  const bool is_number =
      !value.empty() && std::all_of(value.begin(), value.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (entry.first != "frame" || !is_number || rest.empty() || rest[0] < '1' || rest[0] > '9') return value;
  ++i;
  const auto digits = static_cast<std::size_t>(rest[0] - '0');
  return std::string(digits - std::min(digits, value.size()), '0') + value;
}

}  // namespace

bool is_definition_name(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), is_name_character);
}

Definitions::Definitions(const std::vector<std::pair<std::string, std::string>>& defines) {
  for (const auto& [name, value] : defines) {
    defined_.push_back(name);
    values_[name] = value;
  }
}

void Definitions::add_default(const std::string& name, const std::string& value) {
  values_.emplace(name, value);
  used_.insert(name);
}

std::string Definitions::substitute(std::string_view text, const TextLocation& location, const OnError& on_error) {
  return replace(text, location, false, on_error);
}

std::string Definitions::substitute_defined(std::string_view text, const TextLocation& location,
                                            const OnError& on_error) {
  return replace(text, location, true, on_error);
}

std::string Definitions::replace(std::string_view text, const TextLocation& location, bool keep_undefined,
                                 const OnError& on_error) {
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    // Find the end of the name
    std::size_t end = i + 1;
    if (text[i] == '$')
      while (end < text.size() && end - i <= kLongestName && is_name_character(text[end])) ++end;
    const std::string_view name = text.substr(i + 1, end - i - 1);
    if (text[i] == '$' && end < text.size() && text[end] == '(' && name.empty()) {
      // Evaluate the expression
      const std::string value = evaluate(text, i + 1, end, location, on_error);
      substituted_ += value.size();
      result += value;
      i = end;
    } else if (const Entry* entry = name.empty() ? nullptr : longest_prefix(name)) {
      // Substitute the value
      used_.insert(entry->first);
      i += 1 + entry->first.size();
      const std::string value = with_digits(*entry, text.substr(i), i);
      substituted_ += value.size();
      result += value;
    } else {
      // Copy other text
      if (!name.empty() && !keep_undefined) {
        on_error(undefined(std::string(name), location.where));
      } else {
        result += text.substr(i, end - i);
      }
      i = end;
    }
    if (substituted_ > kMaxSubstituted)
      throw SceneError(location.where, "$parameters expand to more than 256 MiB", SceneErrorCode::kTooLarge);
  }
  return result;
}

std::string Definitions::evaluate(std::string_view text, std::size_t open, std::size_t& end,
                                  const TextLocation& location, const OnError& on_error) {
  const std::size_t close = end_of_parentheses(text, open);
  end = std::min(close, text.size());
  const auto fail = [&](std::size_t at, const std::string& message) {
    const std::string column =
        location.column > 0 ? fmt::format("column {}: ", static_cast<std::size_t>(location.column) + at) : "";
    on_error(SceneError(location.where, column + in_quotes(text.substr(open - 1, end - open + 1)) + ": " + message,
                        SceneErrorCode::kSyntax));
    return std::string();
  };
  if (close == std::string_view::npos) return fail(open - 1, "'$(' is not closed, expected ')'");
  const auto lookup = [&](std::string_view name) -> const std::string* {
    const auto found = values_.find(name);
    if (found == values_.end()) return nullptr;
    used_.insert(found->first);
    return &found->second;
  };
  try {
    return expression_result(evaluate_expression(text.substr(open + 1, close - open - 2), lookup));
  } catch (const ExpressionError& error) { return fail(open + 1 + error.at, error.what()); }
}

const Definitions::Entry* Definitions::longest_prefix(std::string_view text) const {
  for (std::size_t length = text.size(); length > 0; --length)
    if (const auto found = values_.find(text.substr(0, length)); found != values_.end()) return &*found;
  return nullptr;
}

SceneError Definitions::undefined(const std::string& name, const SourceLocation& where) const {
  std::vector<std::string> known;
  for (const Entry& entry : values_) known.push_back(entry.first);
  return {where, fmt::format("parameter '${}' is not defined{} (define it by -D {}=value or <default>)", name,
                             did_you_mean(name, known), name)};
}

void Definitions::reject_unused(const std::string& file) const {
  const std::vector<std::string> known(used_.begin(), used_.end());
  for (const std::string& name : defined_)
    if (used_.count(name) == 0)
      throw SceneError(SourceLocation{file, 0},
                       fmt::format("the scene has no parameter {} for -D{} to set{}", in_quotes(name),
                                   name == "frame" ? " or --frames" : "", did_you_mean(name, known)));
}

}  // namespace sheaf

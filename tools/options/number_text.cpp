#include "tools/options/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace sheaf {

namespace {

/// Parses a decimal number at the start of `text` and removes it from `text`. Returns nothing if there is no number.
std::optional<double> take_number(std::string_view& text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec == std::errc::invalid_argument) return std::nullopt;
  // Numbers beyond the range of double become infinite, which no option accepts.
  if (read.ec == std::errc::result_out_of_range) value = std::numeric_limits<double>::infinity();
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return value;
}

}  // namespace

std::optional<double> number_of(std::string_view text) {
  const std::optional<double> value = take_number(text);
  return text.empty() ? value : std::nullopt;
}

std::string shortest(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return std::string(text, end);
}

std::string to_whole_number(std::string& text) {
  constexpr double kExact = 9007199254740992.0;  // 2^53
  const std::optional<double> value = number_of(text);
  if (!value || !std::isfinite(*value)) return fmt::format("'{}' is not a number", text);
  if (*value != std::floor(*value)) return fmt::format("'{}' is not an integer", text);
  if (std::fabs(*value) > kExact) return fmt::format("'{}' is too large", text);
  text = std::to_string(static_cast<long long>(*value));
  return {};
}

std::string to_number(std::string& text) {
  return number_of(text) ? std::string() : fmt::format("'{}' is not a number", text);
}

std::string to_fraction(std::string& text) {
  std::string_view rest = text;
  const std::optional<double> value = take_number(rest);
  if (value && rest == "%") text = shortest(*value / 100);
  return to_number(text);
}

std::string to_seconds(std::string& text) {
  constexpr std::pair<std::string_view, double> kUnits[] = {{"ms", 1e-3},   {"s", 1},        {"sec", 1},
                                                            {"m", 60},      {"min", 60},     {"h", 3600},
                                                            {"hour", 3600}, {"hours", 3600}, {"d", 86400}};
  if (number_of(text)) return {};
  double seconds = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::optional<double> value = take_number(rest);
    const std::string_view unit = rest.substr(0, rest.find_first_of("+-.0123456789 "));
    const auto* const found =
        std::find_if(std::begin(kUnits), std::end(kUnits), [&](const auto& each) { return each.first == unit; });
    if (!value || *value < 0 || found == std::end(kUnits))
      return fmt::format(
          "'{}' is not a time: expected seconds, or a number with ms, s, m, h or d, such as 90s or 1h30m", text);
    seconds += *value * found->second;
    rest.remove_prefix(unit.size());
  }
  text = shortest(seconds);
  return {};
}

}  // namespace sheaf

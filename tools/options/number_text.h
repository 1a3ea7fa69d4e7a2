// Numbers of options as text. The functions that convert a text in place return an error message or an empty string.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sheaf {

/// Parses a text that consists of one decimal number.
std::optional<double> number_of(std::string_view text);

/// The shortest text that represents the number exactly.
std::string shortest(double value);

/// Normalizes integers such as 16.0 and 1e3 to decimal digits.
std::string to_whole_number(std::string& text);

/// Leaves numbers as they are.
std::string to_number(std::string& text);

/// Converts percentages to fractions.
std::string to_fraction(std::string& text);

/// Converts times with units, such as 90s, 5m, 1.5h and 1h30m, to seconds.
std::string to_seconds(std::string& text);

}  // namespace sheaf

// Arithmetic of scene files: the text between the parentheses of `$( ... )`.
#pragma once

#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace sheaf {

/// An error in an expression, at a position in its text.
struct ExpressionError : std::runtime_error {
  ExpressionError(std::size_t position, const std::string& message) : std::runtime_error(message), at(position) {}
  std::size_t at;  ///< characters before the error
};

/// Returns the text of a name; null if the name is not defined.
using NameLookup = std::function<const std::string*(std::string_view name)>;

/// Evaluates an expression in double precision: decimal numbers, names, + - * / % with the usual precedence, unary
/// minus and plus, parentheses, sin and cos of angles in radians, and pi unless `lookup` defines it. The text of a name
/// must be a number. The remainder has the sign of the divisor. Throws ExpressionError for a syntax error, an undefined
/// name, a division by zero, a result that is not finite, more than 1000 characters, and nesting deeper than 50 levels.
double evaluate_expression(std::string_view text, const NameLookup& lookup);

/// The shortest decimal text that parses to the same double. Integers below 2^53 have neither a point nor an exponent.
std::string expression_result(double value);

/// The end of a parenthesized text: the position after the parenthesis that closes the one at `open`, or npos.
std::size_t end_of_parentheses(std::string_view text, std::size_t open);

}  // namespace sheaf

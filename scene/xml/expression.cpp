// A recursive-descent parser that evaluates while it parses:
//
//   sum     = product { ("+" | "-") product }
//   product = factor { ("*" | "/" | "%") factor }
//   factor  = ("-" | "+") factor | number | name | ("sin" | "cos") "(" sum ")" | "(" sum ")"
#include "scene/xml/expression.h"

#include "core/io/error.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

namespace sheaf {

namespace {

class ExpressionParser {
 public:
  ExpressionParser(std::string_view text, const NameLookup& lookup) : text_(text), lookup_(lookup) {}

  double run() {
    if (text_.size() > kMaxLength) fail(0, fmt::format("the expression is longer than {} characters", kMaxLength));
    const double value = sum();
    if (next() != '\0') fail(at_, fmt::format("found {}, expected an operator: + - * / %", found()));
    return value;
  }

 private:
  static constexpr std::size_t kMaxLength = 1000;
  static constexpr int kMaxDepth = 50;

  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

  [[noreturn]] static void fail(std::size_t at, const std::string& message) { throw ExpressionError(at, message); }

  /// Skips spaces and returns the next character; 0 at the end.
  char next() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }

  /// The next character for messages.
  std::string found() { return next() == '\0' ? "the end" : in_quotes(text_.substr(at_, 1)); }

  double finite(double value, std::size_t at) const {
    if (!std::isfinite(value)) fail(at, "the result is too large");
    return value;
  }

  double sum() {
    double value = product();
    for (char sign = next(); sign == '+' || sign == '-'; sign = next()) {
      const std::size_t at = at_++;
      const double other = product();
      value = finite(sign == '+' ? value + other : value - other, at);
    }
    return value;
  }

  double product() {
    double value = factor();
    for (char sign = next(); sign == '*' || sign == '/' || sign == '%'; sign = next()) {
      const std::size_t at = at_++;
      const double other = factor();
      if (sign != '*' && other == 0) fail(at, "division by zero");
      value = finite(sign == '*' ? value * other : sign == '/' ? value / other : remainder(value, other), at);
    }
    return value;
  }

  static double remainder(double value, double divisor) {
    const double rest = std::fmod(value, divisor);
    return rest != 0 && (rest < 0) != (divisor < 0) ? rest + divisor : rest;
  }

  double factor() {
    const char c = next();
    if (++depth_ > kMaxDepth) fail(at_, fmt::format("the expression is nested deeper than {} levels", kMaxDepth));
    double value = 0;
    if (c == '-' || c == '+') {
      ++at_;
      value = factor();
      if (c == '-') value = -value;
    } else if (c == '(') {
      value = parenthesized();
    } else if (is_digit(c) || c == '.') {
      value = number();
    } else if (is_letter(c)) {
      value = name();
    } else {
      fail(at_, fmt::format("found {}, expected a number, a name or '('{}", found(),
                            c == '$' ? "; names are written without $ here" : ""));
    }
    --depth_;
    return value;
  }

  double parenthesized() {
    const std::size_t open = at_++;
    const double value = sum();
    if (next() == '\0') fail(open, "'(' is not closed, expected ')'");
    if (next() != ')') fail(at_, fmt::format("found {}, expected an operator or ')'", found()));
    ++at_;
    return value;
  }

  double number() {
    double value = 0;
    const auto [end, problem] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (problem != std::errc())
      fail(at_, problem == std::errc::result_out_of_range ? "the number is too large or too small"
                                                          : fmt::format("found {}, expected a number", found()));
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }

  double name() {
    // Find the end of the name
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string_view word = text_.substr(begin, at_ - begin);
    // Call a function
    if (next() == '(') {
      if (word != "sin" && word != "cos")
        fail(begin, fmt::format("unknown function {}, expected sin or cos", in_quotes(word)));
      const double angle = parenthesized();
      return word == "sin" ? std::sin(angle) : std::cos(angle);
    }
    // Look up the value
    if (const std::string* value = lookup_(word)) return number_of(*value, word, begin);
    if (word == "pi") return std::numbers::pi;
    fail(begin, fmt::format("{} is not defined (define it by -D {}=value)", in_quotes(word), word.substr(0, 40)));
  }

  static double number_of(std::string_view text, std::string_view word, std::size_t at) {
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
    double value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
      fail(at, fmt::format("{} is {}, expected a number", in_quotes(word), in_quotes(text)));
    return value;
  }

  std::string_view text_;
  const NameLookup& lookup_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

double evaluate_expression(std::string_view text, const NameLookup& lookup) {
  return ExpressionParser(text, lookup).run();
}

std::string expression_result(double value) {
  constexpr double kExactIntegers = 9007199254740992.0;  // 2^53
  value += 0.0;                                          // turns -0 into 0
  char text[32];
  const bool integer = value == std::floor(value) && std::fabs(value) < kExactIntegers;
  const auto end = integer ? std::to_chars(text, text + sizeof(text), value, std::chars_format::fixed)
                           : std::to_chars(text, text + sizeof(text), value);
  return {text, end.ptr};
}

std::size_t end_of_parentheses(std::string_view text, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    if (text[i] == '(') ++depth;
    if (text[i] == ')' && --depth == 0) return i + 1;
  }
  return std::string_view::npos;
}

}  // namespace sheaf

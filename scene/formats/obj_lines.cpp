// Grammar of the relevant OBJ lines.
#include "scene/formats/obj_lines.h"
#include "scene/formats/text.h"

#include <algorithm>

namespace sheaf {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

const char* skip_digits(const char* p, const char* end) { return std::find_if_not(p, end, is_digit); }

/// Whether the whole token is a decimal number that tinyobjloader parses correctly.
bool is_number(std::string_view token) {
  constexpr std::ptrdiff_t kMaxExponentDigits = 4;
  const char *p = token.data(), *const end = p + token.size();
  if (p != end && (*p == '+' || *p == '-')) ++p;
  const char* const whole = p;
  p = skip_digits(p, end);
  std::ptrdiff_t digits = p - whole;
  if (p != end && *p == '.') {
    const char* const fraction = p + 1;
    p = skip_digits(fraction, end);
    digits += p - fraction;
  }
  if (digits == 0) return false;
  if (p == end) return true;
  if (*p != 'e' && *p != 'E') return false;
  ++p;
  if (p != end && (*p == '+' || *p == '-')) ++p;
  const std::ptrdiff_t exponent_digits = end - p;
  return exponent_digits > 0 && exponent_digits <= kMaxExponentDigits && skip_digits(p, end) == end;
}

/// Whether the token is NaN or infinity as printed by C libraries ("-nan", "inf", "1.#QNAN").
bool is_non_finite(std::string_view token) {
  if (!token.empty() && (token[0] == '+' || token[0] == '-')) token.remove_prefix(1);
  std::string lower(token.substr(0, 9));
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower == "nan" || lower == "inf" || lower == "infinity" || lower.starts_with("nan(") ||
         lower.starts_with("1.#");
}

/// Whether the whole token is a nonzero index of at most 9 digits.
bool is_index(std::string_view token) {
  if (!token.empty() && (token[0] == '-' || token[0] == '+')) token.remove_prefix(1);
  return !token.empty() && token.size() <= 9 && std::all_of(token.begin(), token.end(), is_digit) &&
         token.find_first_not_of('0') != std::string_view::npos;
}

/// Returns the next token and advances p past it; blanks out comments. Empty at the end of the line.
std::string_view next_token(char*& p, char* end) {
  p = std::find_if_not(p, end, is_blank);
  if (p != end && *p == '#') {
    std::fill(p, end, ' ');
    p = end;
  }
  char* const begin = p;
  p = std::find_if(p, end, is_blank);
  return {begin, static_cast<std::size_t>(p - begin)};
}

/// Whether the whole token is a face corner without trailing slashes.
bool is_corner(std::string_view token) {
  const std::size_t slash = std::min(token.find('/'), token.size());
  const std::size_t second = std::min(token.find('/', slash + 1), token.size());
  const bool has_uv = second > slash + 1, has_normal = second < token.size();
  return is_index(token.substr(0, slash)) && (!has_uv || is_index(token.substr(slash + 1, second - slash - 1))) &&
         (!has_normal || is_index(token.substr(second + 1)));
}

}  // namespace

ObjLines::int_type ObjLines::underflow() {
  while (text_ != end_) {
    char* const begin = text_;
    char* const stop = end_of_line();
    if (!check(begin, stop)) continue;
    *stop = '\n';
    setg(begin, begin, stop + 1);
    return traits_type::to_int_type(*begin);
  }
  return traits_type::eof();
}

char* ObjLines::end_of_line() {
  line_ = next_line_;
  char* const first = std::find_if_not(text_, end_, is_blank);
  const bool may_continue = first != end_ && (*first == 'v' || *first == 'f');
  for (;;) {
    char* const stop = std::find_if(text_, end_, [](char c) { return c == '\n' || c == '\r'; });
    const std::ptrdiff_t width = *stop == '\r' && stop + 1 != end_ && stop[1] == '\n' ? 2 : 1;
    const bool continues = may_continue && stop != text_ && stop[-1] == '\\' && stop + width != end_;
    text_ = stop + width;
    ++next_line_;
    if (!continues) return stop;
    std::fill(stop - 1, text_, ' ');
  }
}

bool ObjLines::check(char* p, char* end) {
  p = std::find_if_not(p, end, is_blank);
  const std::string_view line(p, static_cast<std::size_t>(end - p));
  non_finite_ = false;
  const auto is_keyword = [&](std::string_view word) {
    return line.starts_with(word) && (line.size() == word.size() || is_blank(line[word.size()]));
  };
  if (is_keyword("v")) {
    check_numbers(p + 1, end, 3, 3, "a vertex line ('v')");
  } else if (is_keyword("vn")) {
    check_numbers(p + 2, end, 3, 3, "a normal line ('vn')");
  } else if (is_keyword("vt")) {
    check_numbers(p + 2, end, 1, 2, "a texture coordinate line ('vt')");
  } else if (is_keyword("f")) {
    check_face(p + 1, end);
  } else if (is_keyword("mtllib")) {
    libraries_.push_back({std::string(trimmed(line.substr(6))), where()});
    return false;
  } else if (is_keyword("s")) {
    read_smoothing_group(p + 1, end);
    return false;
  } else {
    return is_keyword("usemtl");
  }
  return true;
}

void ObjLines::read_smoothing_group(char* p, char* end) {
  const std::string_view token = next_token(p, end);
  std::string_view digits = token;
  if (digits.starts_with('-') || digits.starts_with('+')) digits.remove_prefix(1);
  has_smoothing_groups_ = true;
  smoothing_group_ = 0;
  if (token.empty() || token == "off") return;
  if (token == "on") {
    smoothing_group_ = 1;
    return;
  }
  if (digits.empty() || !std::all_of(digits.begin(), digits.end(), is_digit)) {
    throw SceneError(where(), "expected a smoothing group after 's', a number or 'off', found " + quoted(token));
  }
  for (const char digit : digits) smoothing_group_ = 10 * smoothing_group_ + static_cast<std::uint32_t>(digit - '0');
}

void ObjLines::check_numbers(char* p, char* end, int min_count, int max_count, const char* what) {
  int count = 0;
  for (std::string_view token = next_token(p, end); !token.empty(); token = next_token(p, end)) {
    const bool counts = count++ < max_count;
    if (is_number(token)) continue;
    if (!is_non_finite(token)) {
      throw SceneError(where(), "expected a number in " + std::string(what) + ", found " + quoted(token));
    }
    if (counts) non_finite_ = true;
  }
  if (count < min_count) {
    throw SceneError(where(), "expected at least " + std::to_string(min_count) + " numbers in " + std::string(what) +
                                  ", found " + std::to_string(count));
  }
}

void ObjLines::check_face(char* p, char* end) {
  for (std::string_view token = next_token(p, end); !token.empty(); token = next_token(p, end)) {
    for (char* last = p - 1; token.size() > 1 && *last == '/'; --last) {
      *last = ' ';
      token.remove_suffix(1);
    }
    if (!is_corner(token)) {
      throw SceneError(where(), "expected a face corner such as 1, 1/2, 1//3 or 1/2/3 (indices count from 1), found " +
                                    quoted(token));
    }
  }
}

}  // namespace sheaf

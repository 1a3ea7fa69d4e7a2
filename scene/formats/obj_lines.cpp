// Grammar of the relevant OBJ lines. Most numbers of a file are short decimals, which are exact as a quotient of two
// doubles (Clinger, "How to Read Floating Point Numbers Accurately", 1990); std::from_chars() parses the others.
#include "scene/formats/obj_lines.h"

#include "scene/formats/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <limits>

namespace sheaf {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

const char* skip_blanks(const char* p, const char* end) {
  while (p != end && is_blank(*p)) ++p;
  return p;
}
const char* skip_digits(const char* p, const char* end) {
  while (p != end && is_digit(*p)) ++p;
  return p;
}

/// Returns the next token and moves p past it. Empty at the end of the line and at a comment.
std::string_view next_token(const char*& p, const char* end) {
  p = skip_blanks(p, end);
  if (p != end && *p == '#') p = end;
  const char* const begin = p;
  while (p != end && !is_blank(*p)) ++p;
  return {begin, static_cast<std::size_t>(p - begin)};
}

/// Parses a token of a decimal number without exponent and few digits. Returns its end, or null for other tokens.
const char* parse_short_number(const char* p, const char* end, float& number) {
  constexpr std::ptrdiff_t kMaxDigits = 15;  // exact in double precision
  constexpr std::array<double, kMaxDigits + 1> kPowers{1,   1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                       1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  const bool is_negative = p != end && *p == '-';
  if (is_negative) ++p;
  const char* const begin = p;
  std::int64_t digits = 0;
  for (; p != end && is_digit(*p) && p - begin <= kMaxDigits; ++p) digits = 10 * digits + (*p - '0');
  std::ptrdiff_t count = p - begin, decimals = 0;
  if (p != end && *p == '.') {
    const char* const fraction = ++p;
    for (; p != end && is_digit(*p) && p - begin <= kMaxDigits + 1; ++p) digits = 10 * digits + (*p - '0');
    decimals = p - fraction;
    count += decimals;
  }
  if (count == 0 || count > kMaxDigits || (p != end && !is_blank(*p))) return nullptr;
  const double value = static_cast<double>(digits) / kPowers[static_cast<std::size_t>(decimals)];
  number = static_cast<float>(is_negative ? -value : value);
  return p;
}

/// Parses a token that is a decimal number with an exponent of at most 4 digits. Returns false for other tokens.
bool parse_number(std::string_view token, float& number) {
  constexpr std::ptrdiff_t kMaxExponentDigits = 4;
  if (token.starts_with('+')) token.remove_prefix(1);
  const char *p = token.data(), *const end = p + token.size();
  const bool is_negative = p != end && *p == '-';
  if (is_negative) ++p;
  // Check the grammar
  const char* const whole = p;
  p = skip_digits(p, end);
  std::ptrdiff_t digits = p - whole;
  if (p != end && *p == '.') {
    const char* const fraction = p + 1;
    p = skip_digits(fraction, end);
    digits += p - fraction;
  }
  if (digits == 0) return false;
  if (p != end) {
    if (*p != 'e' && *p != 'E') return false;
    ++p;
    if (p != end && (*p == '+' || *p == '-')) ++p;
    const std::ptrdiff_t exponent_digits = end - p;
    if (exponent_digits == 0 || exponent_digits > kMaxExponentDigits || skip_digits(p, end) != end) return false;
  }
  // Convert it; numbers beyond the range become 0 or infinite
  double value = 0;
  if (std::from_chars(token.data(), end, value).ec == std::errc::result_out_of_range) {
    const bool is_tiny = token.find("e-") != token.npos || token.find("E-") != token.npos;
    value = is_tiny ? 0.0 : std::numeric_limits<double>::infinity();
    if (is_negative) value = -value;
  }
  number = static_cast<float>(value);
  return true;
}

/// Whether the token is NaN or infinity as printed by C libraries ("-nan", "inf", "1.#QNAN").
bool is_non_finite(std::string_view token) {
  if (!token.empty() && (token[0] == '+' || token[0] == '-')) token.remove_prefix(1);
  std::string lower(token.substr(0, 9));
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower == "nan" || lower == "inf" || lower == "infinity" || lower.starts_with("nan(") ||
         lower.starts_with("1.#");
}

/// Parses a nonzero index of at most 9 digits and moves p past it.
bool parse_index(const char*& p, const char* end, int& index) {
  constexpr std::ptrdiff_t kMaxDigits = 9;
  const bool is_negative = p != end && *p == '-';
  if (p != end && (*p == '-' || *p == '+')) ++p;
  const char* const begin = p;
  int value = 0;
  for (; p != end && is_digit(*p) && p - begin < kMaxDigits; ++p) value = 10 * value + (*p - '0');
  index = is_negative ? -value : value;
  return value != 0;
}

/// Parses a token that is a face corner.
bool parse_corner(std::string_view token, ObjIndices& corner) {
  while (token.size() > 1 && token.ends_with('/')) token.remove_suffix(1);
  const char *p = token.data(), *const end = p + token.size();
  corner = {0, 0, 0};
  if (!parse_index(p, end, corner.position)) return false;
  if (p == end) return true;
  if (*p++ != '/') return false;
  if (p != end && *p != '/' && !parse_index(p, end, corner.uv)) return false;
  if (p == end) return true;
  if (*p++ != '/') return false;
  return parse_index(p, end, corner.normal) && p == end;
}

}  // namespace

ObjLines::ObjLines(std::string& text, const std::string& file)
    : text_(text.data()), end_(text_ + text.size()), file_(file), has_carriage_returns_(text.find('\r') != text.npos) {}

ObjLines::Kind ObjLines::next() {
  Kind kind = Kind::kEnd;
  while (text_ != end_) {
    const char* const begin = text_;
    const char* const stop = end_of_line();
    if (parse(skip_blanks(begin, stop), stop, kind)) return kind;
  }
  return Kind::kEnd;
}

const char* ObjLines::end_of_line() {
  line_ = next_line_;
  const char* const first = skip_blanks(text_, end_);
  const bool may_continue = first != end_ && (*first == 'v' || *first == 'f');
  for (;;) {
    // The text ends in a line feed
    auto* stop = static_cast<char*>(std::memchr(text_, '\n', static_cast<std::size_t>(end_ - text_)));
    if (has_carriage_returns_)
      if (void* found = std::memchr(text_, '\r', static_cast<std::size_t>(stop - text_)))
        stop = static_cast<char*>(found);
    const std::ptrdiff_t width = *stop == '\r' && stop + 1 != end_ && stop[1] == '\n' ? 2 : 1;
    const bool continues = may_continue && stop != text_ && stop[-1] == '\\' && stop + width != end_;
    text_ = stop + width;
    ++next_line_;
    if (!continues) return stop;
    std::fill(stop - 1, text_, ' ');
  }
}

bool ObjLines::parse(const char* p, const char* end, Kind& kind) {
  const std::string_view line(p, static_cast<std::size_t>(end - p));
  const auto is_keyword = [&](std::string_view word) {
    return line.starts_with(word) && (line.size() == word.size() || is_blank(line[word.size()]));
  };
  if (is_keyword("v")) {
    parse_numbers(p + 1, end, 3, 3, "a vertex line ('v')");
    kind = Kind::kPosition;
  } else if (is_keyword("vn")) {
    parse_numbers(p + 2, end, 3, 3, "a normal line ('vn')");
    kind = Kind::kNormal;
  } else if (is_keyword("vt")) {
    parse_numbers(p + 2, end, 1, 2, "a texture coordinate line ('vt')");
    kind = Kind::kUv;
  } else if (is_keyword("f")) {
    parse_face(p + 1, end);
    kind = Kind::kFace;
  } else if (is_keyword("usemtl")) {
    constexpr std::size_t kKeyword = 6;
    if (line.size() == kKeyword) return false;
    material_ = unquoted(trimmed(line.substr(kKeyword)));
    kind = Kind::kMaterial;
  } else {
    if (is_keyword("mtllib")) libraries_.push_back({std::string(trimmed(line.substr(6))), where()});
    if (is_keyword("s")) parse_smoothing_group(p + 1, end);
    return false;
  }
  return true;
}

void ObjLines::parse_smoothing_group(const char* p, const char* end) {
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

void ObjLines::parse_numbers(const char* p, const char* end, int min_count, int max_count, const char* what) {
  std::array<float, 3> numbers{};
  is_non_finite_ = false;
  int count = 0;
  for (;; ++count) {
    p = skip_blanks(p, end);
    float number = 0;
    if (const char* const stop = parse_short_number(p, end, number)) {
      p = stop;
    } else {
      const std::string_view token = next_token(p, end);
      if (token.empty()) break;
      if (!parse_number(token, number)) {
        if (!sheaf::is_non_finite(token))
          throw SceneError(where(), "expected a number in " + std::string(what) + ", found " + quoted(token));
        if (count < max_count) is_non_finite_ = true;
      }
    }
    if (count < max_count) numbers[static_cast<std::size_t>(count)] = number;
  }
  if (count < min_count) {
    throw SceneError(where(), "expected at least " + std::to_string(min_count) + " numbers in " + std::string(what) +
                                  ", found " + std::to_string(count));
  }
  numbers_ = {numbers[0], numbers[1], numbers[2]};
}

void ObjLines::parse_face(const char* p, const char* end) {
  corners_.clear();
  for (std::string_view token = next_token(p, end); !token.empty(); token = next_token(p, end)) {
    ObjIndices corner{};
    if (!parse_corner(token, corner)) {
      while (token.size() > 1 && token.ends_with('/')) token.remove_suffix(1);
      throw SceneError(where(), "expected a face corner such as 1, 1/2, 1//3 or 1/2/3 (indices count from 1), found " +
                                    quoted(token));
    }
    corners_.push_back(corner);
  }
}

}  // namespace sheaf

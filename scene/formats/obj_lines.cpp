#include "scene/formats/obj_lines.h"

#include "scene/formats/text.h"

#include <algorithm>
#include <array>
#include <charconv>
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
bool parse_corner(std::string_view token, ObjCorner& corner) {
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

/// Parses the lines of one text.
class LineParser {
 public:
  LineParser(const ObjText& text, std::string_view line, ObjLine& parsed)
      : text_(text), line_(line), end_(line.data() + line.size()), parsed_(parsed) {}

  void parse() {
    using Kind = ObjLine::Kind;
    parsed_.kind = Kind::kIrrelevant;
    const char* p = skip_blanks(line_.data(), end_);
    const std::string_view line(p, static_cast<std::size_t>(end_ - p));
    const auto take_keyword = [&](std::string_view word, Kind kind) {
      if (!line.starts_with(word) || (line.size() > word.size() && !is_blank(line[word.size()]))) return false;
      p += word.size();
      parsed_.kind = kind;
      return true;
    };
    if (take_keyword("v", Kind::kPosition)) {
      parse_numbers(p, 3, 3, "a vertex line ('v')");
    } else if (take_keyword("vn", Kind::kNormal)) {
      parse_numbers(p, 3, 3, "a normal line ('vn')");
    } else if (take_keyword("vt", Kind::kUv)) {
      parse_numbers(p, 1, 2, "a texture coordinate line ('vt')");
    } else if (take_keyword("f", Kind::kFace)) {
      parse_face(p);
    } else if (take_keyword("usemtl", Kind::kMaterial)) {
      if (p == end_) parsed_.kind = Kind::kIrrelevant;
      parsed_.name = unquoted(trimmed({p, end_}));
    } else if (take_keyword("mtllib", Kind::kLibrary)) {
      parsed_.name = trimmed({p, end_});
    } else if (take_keyword("s", Kind::kSmoothing)) {
      parse_smoothing_group(p);
    }
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw SceneError(text_.where(line_.data()), message); }

  /// Parses the argument of 's': a number, 'on' or 'off'.
  void parse_smoothing_group(const char* p) {
    const std::string_view token = next_token(p, end_);
    std::string_view digits = token;
    if (digits.starts_with('-') || digits.starts_with('+')) digits.remove_prefix(1);
    parsed_.group = token == "on" ? 1 : 0;
    if (token.empty() || token == "on" || token == "off") return;
    if (digits.empty() || !std::all_of(digits.begin(), digits.end(), is_digit))
      fail("expected a smoothing group after 's', a number or 'off', found " + quoted(token));
    for (const char digit : digits) parsed_.group = 10 * parsed_.group + static_cast<std::uint32_t>(digit - '0');
  }

  /// Parses at least `min_count` numbers. Only the first `max_count` are relevant.
  void parse_numbers(const char* p, int min_count, int max_count, const char* what) {
    std::array<float, 3> numbers{};
    parsed_.is_non_finite = false;
    int count = 0;
    for (std::string_view token; !(token = next_token(p, end_)).empty(); ++count) {
      float number = 0;
      if (!parse_number(token, number)) {
        if (!is_non_finite(token)) fail(fmt::format("expected a number in {}, found {}", what, quoted(token)));
        if (count < max_count) parsed_.is_non_finite = true;
      }
      if (count < max_count) numbers[static_cast<std::size_t>(count)] = number;
    }
    if (count < min_count) fail(fmt::format("expected at least {} numbers in {}, found {}", min_count, what, count));
    parsed_.numbers = {numbers[0], numbers[1], numbers[2]};
  }

  /// Parses corners v, v/vt, v//vn or v/vt/vn, with trailing slashes ("1//").
  void parse_face(const char* p) {
    parsed_.corners.clear();
    for (std::string_view token; !(token = next_token(p, end_)).empty();) {
      ObjCorner corner{};
      if (!parse_corner(token, corner)) {
        while (token.size() > 1 && token.ends_with('/')) token.remove_suffix(1);
        fail("expected a face corner such as 1, 1/2, 1//3 or 1/2/3 (indices count from 1), found " + quoted(token));
      }
      parsed_.corners.push_back(corner);
    }
  }

  const ObjText& text_;
  const std::string_view line_;
  const char* const end_;
  ObjLine& parsed_;
};

}  // namespace

void parse_obj_line(const ObjText& text, std::string_view line, ObjLine& parsed) {
  LineParser(text, line, parsed).parse();
}

}  // namespace sheaf

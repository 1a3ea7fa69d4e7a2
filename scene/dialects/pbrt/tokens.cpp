// Tokenizer of pbrt scene files.
#include "scene/dialects/pbrt/tokens.h"

#include "scene/xml/expression.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace sheaf::pbrt {

namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

constexpr std::array<bool, 256> kEndsWord = [] {
  std::array<bool, 256> table{};
  for (const char c : {' ', '\t', '\n', '\r', '"', '[', ']', '#'}) table[static_cast<unsigned char>(c)] = true;
  return table;
}();

bool ends_word(char c) { return kEndsWord[static_cast<unsigned char>(c)]; }

/// Returns the character of an escape sequence, or 0.
char unescaped(char c) {
  switch (c) {
    case 'b':
      return '\b';
    case 'f':
      return '\f';
    case 'n':
      return '\n';
    case 'r':
      return '\r';
    case 't':
      return '\t';
    case '\\':
    case '\'':
    case '"':
      return c;
    default:
      return 0;
  }
}

}  // namespace

Tokens::Tokens(std::string text, std::string file, Definitions* definitions)
    : text_(std::move(text)), definitions_(definitions), where_{std::move(file), 1} {
  advance();
}

void Tokens::skip_space() {
  bool comment = false;
  for (; at_ < text_.size(); ++at_) {
    const char c = text_[at_];
    if (c == '\n') {
      ++line_;
      line_start_ = at_ + 1;
      comment = false;
    } else if (c == '#') {
      comment = true;
    } else if (!comment && !is_space(c)) {
      return;
    }
  }
}

void Tokens::read_string() {
  const std::size_t begin = ++at_;
  while (at_ < text_.size() && text_[at_] != '"' && text_[at_] != '\\' && text_[at_] != '\n') ++at_;
  if (at_ < text_.size() && text_[at_] == '"') {
    token_.text = std::string_view(text_).substr(begin, at_++ - begin);
    return;
  }
  // Resolve escapes
  string_.assign(text_, begin, at_ - begin);
  for (; at_ < text_.size() && text_[at_] != '\n'; ++at_) {
    if (text_[at_] == '"') {
      ++at_;
      token_.text = string_;
      return;
    }
    if (text_[at_] == '\\') {
      const char c = at_ + 1 < text_.size() ? unescaped(text_[at_ + 1]) : char{0};
      if (c == 0)
        throw SceneError(where(), "a backslash in a string, expected one of \\\\ \\\" \\' \\n \\t \\r \\b \\f");
      string_ += c;
      ++at_;
    } else {
      string_ += text_[at_];
    }
  }
  throw SceneError(where(), "a string is not closed on its line, expected '\"'");
}

void Tokens::read_word() {
  const std::size_t begin = at_;
  while (at_ < text_.size() && !ends_word(text_[at_])) {
    if (text_[at_] != '$' || definitions_ == nullptr || at_ + 1 == text_.size() || text_[at_ + 1] != '(') {
      ++at_;
      continue;
    }
    // An expression may contain spaces
    constexpr std::size_t kMaxLength = 2000;  // lines may be longer
    const std::string_view rest = std::string_view(text_).substr(at_, kMaxLength);
    const std::size_t end = end_of_parentheses(rest.substr(0, rest.find('\n')), 1);
    if (end == std::string_view::npos)
      throw SceneError(where(),
                       fmt::format("column {}: '$(' is not closed on its line, expected ')'", at_ - line_start_ + 1));
    at_ += end;
  }
  token_.text = std::string_view(text_).substr(begin, at_ - begin);
}

void Tokens::substitute(std::size_t begin) {
  if (definitions_ == nullptr || token_.text.find('$') == std::string_view::npos) return;
  const TextLocation location{where(), static_cast<int>(begin - line_start_) + 1};
  string_ =
      definitions_->substitute_defined(token_.text, location, [](const SceneError& error) { throw SceneError(error); });
  token_.text = string_;
}

void Tokens::advance() {
  skip_space();
  token_ = {};
  where_.line = line_;
  if (at_ == text_.size()) return;
  const char c = text_[at_];
  const std::size_t begin = at_;
  if (c == '"') {
    token_.kind = Token::Kind::kString;
    read_string();
    substitute(begin + 1);
  } else if (c == '[' || c == ']') {
    token_.kind = c == '[' ? Token::Kind::kOpen : Token::Kind::kClose;
    token_.text = std::string_view(text_).substr(at_++, 1);
  } else {
    token_.kind = Token::Kind::kWord;
    read_word();
    substitute(begin);
  }
}

std::string displayed(const Token& token) {
  constexpr std::size_t kLongest = 40;
  if (token.kind == Token::Kind::kEnd) return "the end of the file";
  std::string text(token.text.substr(0, kLongest));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  return fmt::format("'{}{}", text, token.text.size() > kLongest ? "...'" : "'");
}

double number_of(const Token& token, const SourceLocation& where, std::string_view expected) {
  std::string_view text = token.text;
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = problem == std::errc() && end == text.data() + text.size();
  // Numbers below the range of double become 0.
  if (problem == std::errc::result_out_of_range && end == text.data() + text.size() && text.find("e-") != text.npos)
    return 0;
  if (token.kind != Token::Kind::kWord || !whole || !std::isfinite(value))
    throw SceneError(where, fmt::format("found {}, expected {}{}", displayed(token), expected,
                                        token.text.starts_with('$') ? " (define names after $ by -D name=value)" : ""));
  return value;
}

}  // namespace sheaf::pbrt

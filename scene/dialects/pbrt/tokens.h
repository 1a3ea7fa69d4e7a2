// Tokens of pbrt scene files.
#pragma once

#include "scene/xml/definitions.h"

#include <string>
#include <string_view>

namespace sheaf::pbrt {

/// A token of a scene file.
struct Token {
  enum class Kind {
    kEnd,     ///< end of file
    kWord,    ///< directive, number, true or false
    kString,  ///< text between double quotes, with escapes resolved
    kOpen,    ///< [
    kClose    ///< ]
  } kind = Kind::kEnd;
  std::string_view text;  ///< valid until the next token
};

/// Splits a text into tokens, one at a time. Comments start at # and end with the line. In words and strings, `$name`
/// is replaced if the name is defined, and `$(expression)` is evaluated.
class Tokens {
 public:
  /// `file` is used in messages. `definitions`: null: `$` has no meaning. Throws SceneError as advance() does.
  Tokens(std::string text, std::string file, Definitions* definitions = nullptr);

  const Token& current() const { return token_; }
  /// Where the current token begins.
  const SourceLocation& where() const { return where_; }
  /// Advances to the next token. Throws SceneError for a string or an expression that does not end on its line, for
  /// unknown escapes, and for errors of expressions.
  void advance();

 private:
  void skip_space();
  void read_string();
  void read_word();
  /// Substitutes definitions in the token, which begins at `begin`.
  void substitute(std::size_t begin);

  std::string text_, string_;
  Definitions* definitions_;
  std::size_t at_ = 0;
  std::size_t line_start_ = 0;  ///< of the current line in the text
  int line_ = 1;
  Token token_;
  SourceLocation where_;
};

/// Returns the token for messages: quoted, and truncated if long.
std::string displayed(const Token& token);

/// Parses a word as a number. Throws SceneError, naming what was `expected`, if it is not a word or not a finite
/// number.
double number_of(const Token& token, const SourceLocation& where, std::string_view expected);

}  // namespace sheaf::pbrt
